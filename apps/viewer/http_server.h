// SPDX-License-Identifier: Apache-2.0
// The viewer's server: HTTP/1.1 on one address, whose requests are answered by a few functions. It reads no file.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace vesta::app {

struct HttpReply {
  int status = 200;
  std::string type = "text/plain; charset=utf-8", body = {};
  std::vector<std::pair<std::string, std::string>> headers = {};
};

// What follows "?" in the target of a request; of a name given twice one of them.
using HttpQuery = std::map<std::string, std::string>;

struct HttpRoute {
  enum class Guard {
    kNone,   // what everyone may read: it tells nothing of the splat
    kLink,   // the token in the query, as the link has it
    kToken,  // the token in the header X-Vesta-Token, which no foreign page can send
  };
  std::string method, path;  // "GET" or "POST", and "/name"; all others are refused
  Guard guard = Guard::kToken;
  std::function<HttpReply(const HttpQuery&)> reply;  // by several threads at once; Error becomes a 400
};

class HttpServer {
 public:
  // Where nothing else is asked for: the first free port from here on.
  static constexpr int kFirstPort = 7007, kPortsToTry = 100;

  // address: of an interface, as "127.0.0.1" or "0.0.0.0" for all. port: 0: a free one. Serves from here on until it
  // is destroyed. Throws Error, naming --bind, where that cannot be bound.
  HttpServer(const std::string& address, int port, std::vector<HttpRoute> routes);
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  int port() const;
  const std::string& token() const;
  // With the token, to be opened in a browser.
  std::string link() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace vesta::app
