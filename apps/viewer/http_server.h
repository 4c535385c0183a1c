// SPDX-License-Identifier: Apache-2.0
// The HTTP/1.1 server of the viewer. It answers requests with functions (routes) and never serves files.
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

// The parameters of a request, after "?": value by name.
using HttpQuery = std::map<std::string, std::string>;

struct HttpRoute {
  enum class Guard {
    kNone,   // no token is needed: the reply contains nothing about the splat
    kLink,   // the token must be in the query, as in the link that the user opens
    kToken,  // the token must be in the header X-Vesta-Token, which no foreign page can send
  };
  std::string method, path;  // "GET" or "POST", and "/name"
  Guard guard = Guard::kToken;
  // Called by several threads at the same time. If it throws Error, the status is 400.
  std::function<HttpReply(const HttpQuery&)> reply;
};

class HttpServer {
 public:
  // Without a given port, the first free one of kFirstPort, kFirstPort + 1, ... is used; kPortsToTry are tried.
  static constexpr int kFirstPort = 7007, kPortsToTry = 100;

  // Starts to serve, until destruction. address: "127.0.0.1" for this machine only, "0.0.0.0" for all network
  // interfaces. port: 0 for the first free one. Throws Error (one line with --bind) if it cannot listen on the address
  // or port.
  HttpServer(const std::string& address, int port, std::vector<HttpRoute> routes);
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  // The port in use, and the secret token.
  int port() const;
  const std::string& token() const;
  // The link to open in a browser; it contains the token.
  std::string link() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace vesta::app
