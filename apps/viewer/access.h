// SPDX-License-Identifier: Apache-2.0
// Who may read the viewer's pages, and how much is sent at once.
#pragma once

#include <httplib.h>

#include <array>
#include <atomic>
#include <chrono>
#include <string>
#include <string_view>

namespace vesta::app {

// Who may ask a viewer: whoever holds the token of its link. A page of another site that the same browser has open can
// send requests to a loopback address too, which is why there is a token there as well.
// 32 hexadecimal digits from the system's source of randomness. Throws Error where there is none.
std::string MakeToken();

// In a time that does not tell how much of it is right.
bool IsToken(std::string_view given, std::string_view token);

bool IsLoopback(std::string_view address);

// Whether headers are those of a request by the viewer's own page, before the token is looked at. address: that the
// server is bound to. host, origin: headers, empty where there is none. Of a server on a loopback address the host must
// name such, with any port (a tunnel has another): a name that a foreign site points to 127.0.0.1 does not. An origin
// must be the host's own.
bool IsOwnPage(std::string_view address, std::string_view host, std::string_view origin);

// A connection that httplib reads and writes: a request on it takes so many bytes and seconds and no more, however
// slowly it is sent and whatever it claims to be. (httplib bounds each read, not their sum.)
class BoundedStream : public httplib::Stream {
 public:
  static constexpr std::size_t kMostBytes = 16384;  // of a request
  static constexpr std::chrono::seconds kMostToRead{3}, kMostToWrite{20}, kMostIdle{15};

  // Does not close the socket. Once `stopping` nothing is read any more.
  BoundedStream(socket_t socket, const std::atomic<bool>& stopping) : socket_(socket), stopping_(stopping) {}

  // Waits for the first byte of a request. False where none comes.
  bool WaitForRequest();

  bool is_readable() const override { return true; }  // read waits
  bool is_writable() const override { return true; }
  ssize_t read(char* to, size_t size) override;
  ssize_t write(const char* from, size_t size) override;
  void get_remote_ip_and_port(std::string& /*ip*/, int& /*port*/) const override {}
  void get_local_ip_and_port(std::string& /*ip*/, int& /*port*/) const override {}
  socket_t socket() const override { return socket_; }

 private:
  using Clock = std::chrono::steady_clock;
  bool WaitFor(short event, Clock::time_point until) const;
  // Bytes of the socket into the buffer, where it is empty. False at the end or where none come in time.
  bool Fill(Clock::time_point until);

  socket_t socket_;
  const std::atomic<bool>& stopping_;
  std::array<char, 4096> buffer_{};
  std::size_t begin_ = 0, end_ = 0;  // what of the buffer is unread
  std::size_t bytes_left_ = 0;       // of the request
  Clock::time_point read_until_{};
};

}  // namespace vesta::app
