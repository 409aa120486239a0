# SPDX-License-Identifier: MIT
# Fails where jampack.hpp does not include exactly the headers that exist, optional ones left out.
#   cmake -D include_dir=include -P tests/build/umbrella.cmake                  checks it
#   cmake -D include_dir=include -D write=ON -P tests/build/umbrella.cmake      writes it
cmake_path(ABSOLUTE_PATH include_dir)
set(lines "")
foreach(folder IN ITEMS core geometry mesh element material body packing detection law problem solver
                        stepping analysis io)  # the way of the data
  file(GLOB_RECURSE headers RELATIVE ${include_dir} ${include_dir}/jampack/${folder}/*.hpp)
  list(SORT headers)
  list(APPEND all_headers ${headers})
  foreach(header IN LISTS headers)
    file(STRINGS ${include_dir}/${header} optional REGEX "^#include <hdf5\\.h>" LIMIT_COUNT 1)
    if(NOT optional)
      string(APPEND lines "#include <${header}>\n")
    endif()
  endforeach()
  string(APPEND lines "\n")
endforeach()
string(REGEX REPLACE "\n\n+" "\n\n" lines "${lines}")
string(REGEX REPLACE "^\n+|\n+$" "" lines "${lines}")

file(GLOB_RECURSE everything RELATIVE ${include_dir} ${include_dir}/jampack/*.hpp)
list(REMOVE_ITEM everything jampack/jampack.hpp ${all_headers})
if(everything)
  message(FATAL_ERROR "headers in a folder that umbrella.cmake does not know: ${everything}")
endif()

set(wanted "// SPDX-License-Identifier: MIT
#pragma once

// Everything but the headers that need an optional package, in the order of the data.
// clang-format off
${lines}
// clang-format on
")
set(umbrella ${include_dir}/jampack/jampack.hpp)
if(write)
  file(WRITE ${umbrella} "${wanted}")
else()
  file(READ ${umbrella} found)
  if(NOT found STREQUAL wanted)
    message(FATAL_ERROR "jampack.hpp is not what exists; write it again:\n"
                        "cmake -D include_dir=include -D write=ON -P tests/build/umbrella.cmake")
  endif()
endif()
