// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/http_server.h"

#include <fmt/format.h>
#include <httplib.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <deque>
#include <memory>
#include <mutex>
#include <system_error>
#include <thread>

#include "apps/viewer/access.h"
#include "kernels/core/check.h"

namespace vesta::app {
namespace {

// One thread each; two pages use six each. Leaves file descriptors for the program itself.
constexpr int kMostConnections = 48;
constexpr int kMostOnConnection = 10000;  // requests per connection

// Restores the program's SIGPIPE handler, which httplib replaces. (BoundedStream never raises SIGPIPE.)
class KeepSigpipe {
 public:
  KeepSigpipe() { sigaction(SIGPIPE, nullptr, &before_); }
  ~KeepSigpipe() { sigaction(SIGPIPE, &before_, nullptr); }
  KeepSigpipe(const KeepSigpipe&) = delete;
  KeepSigpipe& operator=(const KeepSigpipe&) = delete;

 private:
  struct sigaction before_ = {};
};

[[noreturn]] void FailWithoutThreads(const std::system_error& error) {
  Fail(kUnavailable,
       "the page needs {} threads, but the system starts no more: {}; end other programs, or allow more (ulimit -u)",
       kMostConnections + 1, error.code().message());
}

// On the accepting thread: whether to close the current connection.
thread_local bool t_refuses = false;

// One thread per connection. Further connections are closed at once.
class Workers : public httplib::TaskQueue {
 public:
  // Throws Error if no more threads start. (httplib's own queue would end the program.)
  Workers() {
    threads_.reserve(kMostConnections);
    try {
      for (int k = 0; k < kMostConnections; ++k) threads_.emplace_back([this] { Work(); });
    } catch (const std::system_error& error) {
      shutdown();
      FailWithoutThreads(error);
    }
  }
  ~Workers() override { shutdown(); }

  // void before httplib 0.15, bool since then.
  using Enqueued = decltype(std::declval<httplib::TaskQueue&>().enqueue(nullptr));
  Enqueued enqueue(std::function<void()> connection) override {
    {
      const std::lock_guard lock(mutex_);
      if (open_ < kMostConnections) {
        ++open_, waiting_.push_back(std::move(connection));
        changed_.notify_one();
        return Enqueued(true);
      }
    }
    t_refuses = true;
    connection();
    t_refuses = false;
    return Enqueued(true);
  }
  void shutdown() override {
    {
      const std::lock_guard lock(mutex_);
      ends_ = true;
    }
    changed_.notify_all();
    for (std::thread& thread : threads_) thread.join();
    threads_.clear();
  }

 private:
  // Until shutdown, and on connections that still wait then.
  void Work() {
    std::unique_lock lock(mutex_);
    for (;;) {
      changed_.wait(lock, [&] { return ends_ || !waiting_.empty(); });
      if (waiting_.empty()) return;
      const std::function<void()> connection = std::move(waiting_.front());
      waiting_.pop_front();
      lock.unlock();
      connection();
      lock.lock();
      --open_;
    }
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> waiting_;
  int open_ = 0;  // waiting and active connections
  bool ends_ = false;
  std::vector<std::thread> threads_;
};

// httplib's server on BoundedStreams.
class BoundedServer : public httplib::Server {
 public:
  void Stop() {
    stopping_ = true;
    stop();
  }

 private:
  bool process_and_close_socket(socket_t socket) override {
    BoundedStream stream(socket, stopping_);
    bool goes_on = !t_refuses;
    for (int count = 1; goes_on && stream.WaitForRequest(); ++count) {
      const bool is_last = count == kMostOnConnection;
      bool is_sound = false, has_body = false, is_closed = false;
      // After a request with a body, which none needs, or an invalid one, nothing more is read from the connection.
      const auto look = [&](httplib::Request& request) {
        is_sound = true;
        const std::string length = request.get_header_value("Content-Length");
        has_body = request.has_header("Transfer-Encoding") || (!length.empty() && length != "0");
      };
      goes_on = Process(stream, is_last, is_closed, look) && is_sound && !is_last && !is_closed && !has_body;
    }
    ::shutdown(socket, SHUT_RDWR);
    ::close(socket);
    return true;
  }

  // Since httplib 0.17, process_request also takes both addresses, which only logs use.
  template <class Stream, class Look>
  bool Process(Stream& stream, bool is_last, bool& is_closed, const Look& look) {
    if constexpr (requires { this->process_request(stream, is_last, is_closed, look); }) {
      return this->process_request(stream, is_last, is_closed, look);
    } else {
      return this->process_request(stream, std::string(), 0, std::string(), 0, is_last, is_closed, look);
    }
  }

  std::atomic<bool> stopping_{false};
};

// For every reply: the page loads only from this server, no other page may embed or read it, and the token in the link
// is not sent to other sites.
const httplib::Headers& SafeHeaders() {
  static const httplib::Headers headers = {
      {"Content-Security-Policy",
       "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src data:; base-uri 'none'; "
       "form-action 'none'; frame-ancestors 'none'"},
      {"X-Content-Type-Options", "nosniff"},
      {"X-Frame-Options", "DENY"},
      {"Referrer-Policy", "no-referrer"},
      {"Cross-Origin-Resource-Policy", "same-origin"},
      {"Cross-Origin-Opener-Policy", "same-origin"},
      {"Cache-Control", "no-store"},
  };
  return headers;
}

}  // namespace

class HttpServer::Impl {
 public:
  Impl(const std::string& address, int port, std::vector<HttpRoute> routes)
      : address_(address), token_(MakeToken()), routes_(std::move(routes)) {
    Bind(port);
    try {
      thread_ = std::thread([this] { server_->listen_after_bind(); });
    } catch (const std::system_error& error) {
      FailWithoutThreads(error);
    }
    while (!server_->is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  ~Impl() {
    server_->Stop();
    thread_.join();
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  int port() const { return port_; }
  const std::string& token() const { return token_; }
  std::string link() const {
    const bool is_any = address_ == "0.0.0.0" || address_ == "::";
    const std::string host = is_any                                    ? HostName()
                             : address_.find(':') == std::string::npos ? address_
                                                                       : "[" + address_ + "]";
    return fmt::format("http://{}:{}/?token={}", host, port_, token_);
  }

 private:
  static std::string HostName() {
    char name[256] = {};
    return ::gethostname(name, sizeof(name) - 1) == 0 ? name : "localhost";
  }

  // A server of httplib 0.18 that failed to bind once never binds again, so each port gets a new one.
  void Open() {
    const KeepSigpipe keep;
    server_ = std::make_unique<BoundedServer>();
    server_->new_task_queue = [this] { return workers_.release(); };
    server_->set_tcp_nodelay(true);
    server_->set_keep_alive_max_count(kMostOnConnection);  // announced in replies
    server_->set_keep_alive_timeout(BoundedStream::kMostIdle.count());
    // httplib would share the port with other programs (SO_REUSEPORT).
    server_->set_socket_options([](socket_t socket) {
      const int yes = 1;
      setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
    });
    server_->set_default_headers(SafeHeaders());
    server_->set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
      const HttpReply reply = Answer(request);
      response.status = reply.status;
      for (const auto& [name, value] : reply.headers) response.set_header(name, value);
      response.set_content(reply.body, reply.type);
      return httplib::Server::HandlerResponse::Handled;
    });
  }

  void Bind(int port) {
    const int first = port > 0 ? port : kFirstPort, count = port > 0 ? 1 : kPortsToTry;
    for (port_ = first; port_ < first + count; ++port_) {
      Open();
      if (server_->bind_to_port(address_, port_)) return;
    }
    const std::string ports = count > 1
                                  ? fmt::format("its ports from {} to {} are all in use", first, first + count - 1)
                                  : fmt::format("its port {} is not free", first);
    Fail(kUnavailable, "--bind={}: not an address of this machine, or {}; give another one", address_, ports);
  }

  HttpReply Answer(const httplib::Request& request) const {
    if (!IsOwnPage(address_, request.get_header_value("Host"), request.get_header_value("Origin"))) {
      return {403, "text/plain", "this request is not from the viewer's own page\n"};
    }
    if (!request.ranges.empty()) return {400, "text/plain", "ranges are not supported\n"};
    const auto is_asked = [&](const HttpRoute& route) { return route.path == request.path; };
    const auto at_path = std::ranges::find_if(routes_, is_asked);
    if (at_path == routes_.end()) return {404, "text/plain", "no such page\n"};
    const HttpRoute& route = *at_path;
    if (route.method != request.method) return {405, "text/plain", "wrong HTTP method\n"};
    if (!IsAllowed(route, request)) {
      return {403, "text/plain", "the token is missing or wrong: open the link that vesta printed\n"};
    }
    try {
      return route.reply(HttpQuery(request.params.begin(), request.params.end()));
    } catch (const Error& error) {
      return {400, "text/plain; charset=utf-8", fmt::format("{}\n", error.what())};
    } catch (const std::exception& error) {
      return {500, "text/plain; charset=utf-8", fmt::format("{}\n", error.what())};
    }
  }

  bool IsAllowed(const HttpRoute& route, const httplib::Request& request) const {
    switch (route.guard) {
      case HttpRoute::Guard::kNone:
        return true;
      case HttpRoute::Guard::kLink:
        return IsToken(request.get_param_value("token"), token_);
      case HttpRoute::Guard::kToken:
        return IsToken(request.get_header_value("X-Vesta-Token"), token_);
    }
    return false;
  }

  std::string address_, token_;
  std::vector<HttpRoute> routes_;
  int port_ = 0;
  std::unique_ptr<Workers> workers_ = std::make_unique<Workers>();  // until the server takes them
  std::unique_ptr<BoundedServer> server_;
  std::thread thread_;
};

HttpServer::HttpServer(const std::string& address, int port, std::vector<HttpRoute> routes)
    : impl_(std::make_unique<Impl>(address, port, std::move(routes))) {}
HttpServer::~HttpServer() = default;

int HttpServer::port() const { return impl_->port(); }
const std::string& HttpServer::token() const { return impl_->token(); }
std::string HttpServer::link() const { return impl_->link(); }

}  // namespace vesta::app
