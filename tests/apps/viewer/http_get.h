// SPDX-License-Identifier: Apache-2.0
// A client that can send arbitrary bytes.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <cstdint>
#include <string>

namespace vesta::test {

// A connection to a port of 127.0.0.1.
class Connection {
 public:
  explicit Connection(int port) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(port));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const timeval most{30, 0};
    setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &most, sizeof(most));
    is_open_ = ::connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof(to)) == 0;
  }
  ~Connection() { ::close(socket_); }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  bool is_open() const { return is_open_; }
  // Returns false if the other end has closed.
  bool Send(const std::string& bytes) const {
    std::size_t done = 0;
    while (done < bytes.size()) {
      const ssize_t sent = ::send(socket_, bytes.data() + done, bytes.size() - done, MSG_NOSIGNAL);
      if (sent <= 0) return false;
      done += static_cast<std::size_t>(sent);
    }
    return true;
  }
  void EndSending() const { ::shutdown(socket_, SHUT_WR); }
  // Reads until the other end closes.
  std::string Receive() const {
    std::string all;
    char part[4096];
    for (ssize_t got; (got = ::recv(socket_, part, sizeof(part), 0)) > 0;)
      all.append(part, static_cast<std::size_t>(got));
    return all;
  }

 private:
  int socket_;
  bool is_open_ = false;
};

struct Reply {
  int status = 0;  // 0: no reply
  std::string headers, body;
};

// Reads until the connection ends.
inline Reply Ask(int port, const std::string& request) {
  const Connection connection(port);
  connection.Send(request);
  connection.EndSending();
  const std::string all = connection.Receive();
  Reply reply;
  if (!all.starts_with("HTTP/1.1 ")) return reply;
  reply.status = std::stoi(all.substr(9, 3));
  const std::size_t end = all.find("\r\n\r\n");
  reply.headers = all.substr(0, end);
  if (end != std::string::npos) reply.body = all.substr(end + 4);
  return reply;
}

// token: may be empty. headers: additional ones, with line ends.
inline std::string Request(const std::string& method, const std::string& target, const std::string& token,
                           const std::string& headers = "") {
  std::string text = method + " " + target + " HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n" + headers;
  if (!token.empty()) text += "X-Vesta-Token: " + token + "\r\n";
  return text + "\r\n";
}

}  // namespace vesta::test
