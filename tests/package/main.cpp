// Builds against the installed package alone and returns 0 when the library answers correctly.
#include <stark/stark.h>

int main() {
  bool thrown = false;
  try {
    STARK_CHECK(false);
  } catch (const stark::Error&) {
    thrown = true;
  }
  return thrown ? 0 : 1;
}
