// SPDX-License-Identifier: Apache-2.0
// libjpeg, whose errors leave by longjmp: what may fail is a function of its own that holds no object with a
// destructor.
#pragma once

#include <csetjmp>
#include <cstddef>
#include <cstdio>

// jpeglib.h needs the above; the values in jerror.h depend on jpeglib.h.
// clang-format off
#include <jpeglib.h>
#include <jerror.h>
// clang-format on

namespace vesta::gs {

// Where a function that calls the library comes back to after an error, by setjmp(jump), and why.
struct JpegErrors {
  jpeg_error_mgr manager;  // first, so that the library's pointer is ours
  std::jmp_buf jump;
  char message[JMSG_LENGTH_MAX];

  // What jpeg_std_error fills in, but for errors that come back.
  jpeg_error_mgr* Use() {
    jpeg_error_mgr* used = jpeg_std_error(&manager);
    used->error_exit = Leave;
    return used;
  }
  [[noreturn]] static void Leave(j_common_ptr info) {
    auto* errors = reinterpret_cast<JpegErrors*>(info->err);
    errors->manager.format_message(info, errors->message);
    std::longjmp(errors->jump, 1);
  }
};

}  // namespace vesta::gs
