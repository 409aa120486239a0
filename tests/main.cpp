// SPDX-License-Identifier: MIT
// The test runner's main, compiled once for all test programs.
#define CATCH_CONFIG_MAIN
#include "catch.hpp"
