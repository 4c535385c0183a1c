// SPDX-License-Identifier: Apache-2.0
// Access control of the viewer's HTTP server, and limits on size and time of requests.
#pragma once

#include <httplib.h>

#include <array>
#include <atomic>
#include <chrono>
#include <string>
#include <string_view>

namespace vesta::app {

// The secret token of a viewer's link: 32 hexadecimal digits from the system's random numbers. Requests for the splat
// need the token even if the server has a loopback address (127.0.0.1), because any site open in the same browser can
// send requests to this address. Throws Error if the system has no random numbers.
std::string MakeToken();

// Compares in constant time, so that the time reveals nothing about the token.
bool IsToken(std::string_view given, std::string_view token);

bool IsLoopback(std::string_view address);

// Whether a request comes from the viewer's own page, judging by its headers Host and Origin (empty if missing). If
// `address`, on which the server listens, is a loopback address, the host must be one too, so a foreign name that
// resolves to 127.0.0.1 is rejected. Any port is valid, because tunnels change it. An origin must equal the host.
bool IsOwnPage(std::string_view address, std::string_view host, std::string_view origin);

// A connection for cpp-httplib that limits bytes and time of a whole request; httplib itself limits only each read.
class BoundedStream : public httplib::Stream {
 public:
  static constexpr std::size_t kMostBytes = 16384;  // per request
  static constexpr std::chrono::seconds kMostToRead{3}, kMostToWrite{20}, kMostIdle{15};

  // The caller closes the socket. After `stopping` is true, nothing more is read.
  BoundedStream(socket_t socket, const std::atomic<bool>& stopping) : socket_(socket), stopping_(stopping) {}

  // Returns false if no byte of a request arrives in time.
  bool WaitForRequest();

  // Members of Stream in some versions of httplib only, so not marked `override`. read and write wait.
#if defined(__clang__)
#pragma clang diagnostic push
#pragma clang diagnostic ignored "-Winconsistent-missing-override"
#endif
  // NOLINTBEGIN(modernize-use-override,readability-convert-member-functions-to-static)
  bool is_readable() const { return true; }
  bool is_writable() const { return true; }
  bool wait_readable() const { return true; }
  bool wait_writable() const { return true; }
  time_t duration() const { return 0; }
  // NOLINTEND(modernize-use-override,readability-convert-member-functions-to-static)
#if defined(__clang__)
#pragma clang diagnostic pop
#endif
  ssize_t read(char* to, size_t size) override;
  ssize_t write(const char* from, size_t size) override;
  void get_remote_ip_and_port(std::string& /*ip*/, int& /*port*/) const override {}
  void get_local_ip_and_port(std::string& /*ip*/, int& /*port*/) const override {}
  socket_t socket() const override { return socket_; }

 private:
  using Clock = std::chrono::steady_clock;
  bool WaitFor(short event, Clock::time_point until) const;
  // Fills an empty buffer from the socket. Returns false at the end of the input or on a timeout.
  bool Fill(Clock::time_point until);

  socket_t socket_;
  const std::atomic<bool>& stopping_;
  std::array<char, 4096> buffer_{};
  std::size_t begin_ = 0, end_ = 0;  // unread part of the buffer
  std::size_t bytes_left_ = 0;       // that this request may read
  Clock::time_point read_until_{};
};

}  // namespace vesta::app
