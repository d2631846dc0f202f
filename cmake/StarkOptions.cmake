# Compiler options shared by every target, carried by the interface target stark_options.
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()
set(CMAKE_CXX_FLAGS_RELEASE "-O3 -DNDEBUG")
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
find_package(Threads REQUIRED)

option(STARK_CCACHE "Compile through ccache when it is installed" ON)
find_program(STARK_CCACHE_PROGRAM ccache)
mark_as_advanced(STARK_CCACHE_PROGRAM)
if(STARK_CCACHE AND STARK_CCACHE_PROGRAM AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${STARK_CCACHE_PROGRAM})
endif()

add_library(stark_options INTERFACE)
target_compile_features(stark_options INTERFACE cxx_std_20)
target_link_libraries(stark_options INTERFACE Threads::Threads)
# Contraction is off: the same source gives the same bits wherever a fused multiply-add is not written out.
# Designated initialisers that leave the rest at its default are the intended way to fill descriptions.
target_compile_options(stark_options INTERFACE
  $<BUILD_INTERFACE:-Wall> $<BUILD_INTERFACE:-Wextra> $<BUILD_INTERFACE:-Wshadow>
  $<BUILD_INTERFACE:-Wno-missing-field-initializers>
  $<BUILD_INTERFACE:-Wno-psabi> -ffp-contract=off $<BUILD_INTERFACE:-fno-math-errno>)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  # GCC 12 reports an impossible overlap inside std::string's operator+ (GCC bug 105651).
  target_compile_options(stark_options INTERFACE $<BUILD_INTERFACE:-Wno-restrict>)
endif()
if(STARK_WARNINGS_AS_ERRORS)
  target_compile_options(stark_options INTERFACE $<BUILD_INTERFACE:-Werror>)
endif()

if(STARK_ARCH STREQUAL "" AND CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  set(stark_arch_flag -march=x86-64-v3)
elseif(NOT STARK_ARCH STREQUAL "")
  set(stark_arch_flag -march=${STARK_ARCH})
endif()
if(stark_arch_flag)
  target_compile_options(stark_options INTERFACE $<BUILD_INTERFACE:${stark_arch_flag}>)
endif()

if(STARK_SANITIZE)
  target_compile_options(stark_options INTERFACE -fsanitize=${STARK_SANITIZE} -fno-omit-frame-pointer -g
    -D_GLIBCXX_ASSERTIONS)
  target_link_options(stark_options INTERFACE -fsanitize=${STARK_SANITIZE})
endif()
