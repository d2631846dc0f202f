# The C++ package: cmake --install BUILD --component cpp, then find_package(Stark) and link Stark::Stark.
# The list of installed headers, not a second source tree, defines what is public: everything outside detail/.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

get_property(stark_layers GLOBAL PROPERTY STARK_LAYERS)
add_library(stark_all INTERFACE)
set_target_properties(stark_all PROPERTIES EXPORT_NAME Stark)
target_link_libraries(stark_all INTERFACE ${stark_layers})
add_library(Stark::Stark ALIAS stark_all)

install(TARGETS stark_all stark_options ${stark_layers} EXPORT StarkTargets
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT cpp)
install(EXPORT StarkTargets NAMESPACE Stark:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/Stark COMPONENT cpp)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/src/stark DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT cpp
        FILES_MATCHING PATTERN *.h PATTERN *.inc PATTERN detail EXCLUDE)

configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/StarkConfig.cmake.in ${PROJECT_BINARY_DIR}/StarkConfig.cmake
                              INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/Stark)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/StarkConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/StarkConfig.cmake ${PROJECT_BINARY_DIR}/StarkConfigVersion.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/Stark COMPONENT cpp)
