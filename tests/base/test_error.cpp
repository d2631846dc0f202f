// The exception hierarchy, which users and the Python binding rely on, and the text of failed checks.
#include <stark/base/error.h>

#include <string>
#include <type_traits>

#include <doctest/doctest.h>

TEST_CASE("every exception is a stark::Error and a std::runtime_error") {
  CHECK(std::is_base_of_v<std::runtime_error, stark::Error>);
  CHECK(std::is_base_of_v<stark::Error, stark::InvalidArgument>);
  CHECK(std::is_base_of_v<stark::InvalidArgument, stark::InvalidSetting>);
  CHECK(std::is_base_of_v<stark::InvalidArgument, stark::InvalidMesh>);
  CHECK(std::is_base_of_v<stark::InvalidArgument, stark::InitialIntersection>);
  CHECK(std::is_base_of_v<stark::Error, stark::InternalError>);
  CHECK_FALSE(std::is_base_of_v<stark::InvalidArgument, stark::InternalError>);
}

TEST_CASE("a check that holds does nothing, one that fails names condition and place") {
  int evaluations = 0;
  CHECK_NOTHROW(STARK_CHECK(++evaluations == 1));
  CHECK(evaluations == 1);
  try {
    STARK_CHECK(evaluations == 2);
    FAIL("the check passed");
  } catch (const stark::InternalError& error) {
    const std::string text = error.what();
    CHECK(text.find("evaluations == 2") != std::string::npos);
    CHECK(text.find("test_error.cpp") != std::string::npos);
  }
}
