// SPDX-License-Identifier: Apache-2.0
// The viewer's HTTP/1.1 server. Functions (routes) answer requests; it never serves files.
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

// Parameters of a request, after "?": value by name.
using HttpQuery = std::map<std::string, std::string>;

struct HttpRoute {
  enum class Guard {
    kNone,   // no token needed: the reply tells nothing about the splat
    kLink,   // token in the query, as in the link that the user opens
    kToken,  // token in the header X-Vesta-Token, which no foreign page can send
  };
  std::string method, path;  // "GET" or "POST", and "/name"
  Guard guard = Guard::kToken;
  // Called by several threads at once. If it throws Error, the status is 400.
  std::function<HttpReply(const HttpQuery&)> reply;
};

class HttpServer {
 public:
  // Without a given port, the server tries kPortsToTry ports from kFirstPort on and takes the first free one.
  static constexpr int kFirstPort = 7007, kPortsToTry = 100;

  // Serves until destruction. address: "127.0.0.1" for this machine only, "0.0.0.0" for all network interfaces. port: 0
  // for the first free one. Throws Error (one line with --bind) if the server cannot listen there.
  HttpServer(const std::string& address, int port, std::vector<HttpRoute> routes);
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  // The port in use, and the secret token.
  int port() const;
  const std::string& token() const;
  // The link for a browser, with the token.
  std::string link() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace vesta::app
