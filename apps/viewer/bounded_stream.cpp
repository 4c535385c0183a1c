#include "apps/viewer/bounded_stream.h"

#include <poll.h>

#include <algorithm>
#include <cerrno>

namespace vesta::app {

bool BoundedStream::WaitFor(short event, Clock::time_point until) const {
  constexpr std::chrono::milliseconds kSlice{50};  // after which the server may be stopping
  while (!stopping_) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now());
    if (left.count() <= 0) return false;
    pollfd poll_socket{.fd = socket_, .events = event, .revents = 0};
    const int ready = ::poll(&poll_socket, 1, static_cast<int>(std::min(left, kSlice).count()));
    if (ready > 0) return true;
    if (ready < 0 && errno != EINTR) return false;
  }
  return false;
}

bool BoundedStream::Fill(Clock::time_point until) {
  if (begin_ < end_) return true;
  if (!WaitFor(POLLIN, until)) return false;
  const ssize_t got = ::recv(socket_, buffer_.data(), buffer_.size(), 0);
  begin_ = 0, end_ = got > 0 ? static_cast<std::size_t>(got) : 0;
  return got > 0;
}

bool BoundedStream::WaitForRequest() {
  if (!Fill(Clock::now() + kMostIdle)) return false;
  bytes_left_ = kMostBytes;
  read_until_ = Clock::now() + kMostToRead;
  return true;
}

ssize_t BoundedStream::read(char* to, size_t size) {
  if (bytes_left_ == 0 || !Fill(read_until_)) return -1;
  const std::size_t count = std::min({size, end_ - begin_, bytes_left_});
  std::copy_n(buffer_.data() + begin_, count, to);
  begin_ += count, bytes_left_ -= count;
  return static_cast<ssize_t>(count);
}

ssize_t BoundedStream::write(const char* from, size_t size) {
  const Clock::time_point until = Clock::now() + kMostToWrite;
  std::size_t done = 0;
  while (done < size) {
    if (!WaitFor(POLLOUT, until)) return -1;
    const ssize_t sent = ::send(socket_, from + done, size - done, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent > 0) done += static_cast<std::size_t>(sent);
    if (sent < 0 && errno != EAGAIN && errno != EINTR) return -1;
  }
  return static_cast<ssize_t>(size);
}

}  // namespace vesta::app
