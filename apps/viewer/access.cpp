// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/access.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/random.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstdint>

#include "kernels/core/check.h"

namespace vesta::app {
namespace {

// Without the port: "127.0.0.1" for "127.0.0.1:7007", "::1" for "[::1]:7007".
std::string_view NameOf(std::string_view host) {
  if (host.starts_with('[')) return host.substr(1, host.find(']') - 1);
  return host.substr(0, host.find(':'));
}

bool IsEqualIgnoringCase(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::tolower(static_cast<unsigned char>(a[i])) != std::tolower(static_cast<unsigned char>(b[i]))) return false;
  }
  return true;
}

}  // namespace

std::string MakeToken() {
  std::array<unsigned char, 16> bytes{};
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
    Fail(kUnavailable, "the system provides no random numbers for the viewer's token");
  }
  std::string token;
  for (const unsigned char byte : bytes) token += fmt::format("{:02x}", byte);
  return token;
}

bool IsToken(std::string_view given, std::string_view token) {
  if (given.size() != token.size() || token.empty()) return false;
  unsigned difference = 0;
  for (std::size_t i = 0; i < token.size(); ++i) {
    difference |= static_cast<unsigned>(static_cast<unsigned char>(given[i]) ^ static_cast<unsigned char>(token[i]));
  }
  return difference == 0;
}

bool IsLoopback(std::string_view address) {
  in_addr ip{};
  const bool is_ip = ::inet_pton(AF_INET, std::string(address).c_str(), &ip) == 1;
  constexpr std::uint32_t kNetwork = 127;
  return address == "::1" || IsEqualIgnoringCase(address, "localhost") || (is_ip && ntohl(ip.s_addr) >> 24 == kNetwork);
}

bool IsOwnPage(std::string_view address, std::string_view host, std::string_view origin) {
  if (host.empty()) return false;
  if (IsLoopback(address) && !IsLoopback(NameOf(host))) return false;
  return origin.empty() || IsEqualIgnoringCase(origin, fmt::format("http://{}", host));
}

bool BoundedStream::WaitFor(short event, Clock::time_point until) const {
  constexpr std::chrono::milliseconds kSlice{50};  // interval for checking stopping_
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
