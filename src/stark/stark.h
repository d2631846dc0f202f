// The whole public interface in one include, for programs that use the library. Never included inside it.
#pragma once

#include <stark/base/error.h>
#include <stark/base/math.h>
#include <stark/base/rotation.h>
