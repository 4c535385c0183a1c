// SPDX-License-Identifier: Apache-2.0
// The HTTP/1.1 server of the viewer: a few routes on one address. It reads no files.
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

// The parameters after "?" in a request; one value per name.
using HttpQuery = std::map<std::string, std::string>;

struct HttpRoute {
  enum class Guard {
    kNone,   // public: reveals nothing about the splat
    kLink,   // needs the token in the query, as in the link
    kToken,  // needs the token in the header X-Vesta-Token, which no foreign page can send
  };
  std::string method, path;  // "GET" or "POST", and "/name"
  Guard guard = Guard::kToken;
  std::function<HttpReply(const HttpQuery&)> reply;  // called by several threads; an Error becomes status 400
};

class HttpServer {
 public:
  // The default port is the first free one of these.
  static constexpr int kFirstPort = 7007, kPortsToTry = 100;

  // address: "127.0.0.1" for this machine only, "0.0.0.0" for all interfaces. port: 0 for the first free one. Serves
  // until destruction. Throws Error with --bind if the address cannot be bound.
  HttpServer(const std::string& address, int port, std::vector<HttpRoute> routes);
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  int port() const;
  const std::string& token() const;
  // The link with the token, for a browser.
  std::string link() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace vesta::app
