// SPDX-License-Identifier: Apache-2.0
// An object whose memory goes from one owner to the next.
#pragma once

#include <memory>

namespace vesta {

// Remembers the last T that it gave out, and gives it out again once nobody else holds it.
template <class T>
class Kept {
 public:
  template <class Make>
  std::shared_ptr<T> Get(const Make& make) {
    if (!last_ || last_.use_count() > 1) last_ = make();
    return last_;
  }

 private:
  std::shared_ptr<T> last_;
};

}  // namespace vesta
