// SPDX-License-Identifier: Apache-2.0
// Ten thousand malformed or malicious requests: the server survives, reveals nothing and executes nothing.
#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "apps/viewer/http_server.h"
#include "tests/apps/viewer/http_get.h"

namespace vesta::app {
namespace {

using test::Ask;
using test::Connection;
using test::Request;

class HostileRequests : public testing::Test {
 protected:
  HttpReply Do() {
    ++done_;
    return {.body = "done\n"};
  }
  bool IsAlive() { return Ask(server_.port(), Request("GET", "/state", server_.token())).status == 200; }

  std::atomic<int> done_{0};
  HttpServer server_{
      "127.0.0.1",
      0,
      {{"GET", "/", HttpRoute::Guard::kLink, [this](const HttpQuery&) { return Do(); }},
       {"GET", "/state", HttpRoute::Guard::kToken, [](const HttpQuery&) { return HttpReply{.body = "{}"}; }},
       {"POST", "/stop", HttpRoute::Guard::kToken, [this](const HttpQuery&) { return Do(); }}}};
};

using Random = std::mt19937;

std::size_t Below(Random& random, std::size_t count) { return random() % count; }

std::string Noise(Random& random, std::size_t most) {
  std::string noise(Below(random, most), '\0');
  for (char& c : noise) c = static_cast<char>(random());
  return noise;
}

// token: a wrong one.
std::string Hostile(Random& random, const std::string& token) {
  static const std::vector<std::string> targets = {"/../../../../etc/passwd",
                                                   "/%2e%2e/%2e%2e/etc/passwd",
                                                   "/..%2f..%2fetc%2fpasswd",
                                                   "//etc/passwd",
                                                   "/page.js/../../../etc/passwd",
                                                   "/.//....//etc/passwd",
                                                   "/%00/etc/passwd",
                                                   "/stop",
                                                   "/state",
                                                   "/",
                                                   "/?token=",
                                                   "/?token[]=1&token=" + token,
                                                   "/stop?token=" + token,
                                                   "file:///etc/passwd",
                                                   "http://evil.example/",
                                                   "*",
                                                   "",
                                                   "/%zz%",
                                                   "/" + std::string(9000, 'a'),
                                                   "/?" + std::string(7000, '&')};
  static const std::vector<std::string> methods = {"GET",  "POST", "PUT",     "DELETE", "OPTIONS",
                                                   "HEAD", "PRI",  "CONNECT", "get",    "G T"};
  static const std::vector<std::string> headers = {"Origin: http://evil.example\r\n",
                                                   "Host: evil.example\r\n",
                                                   "X-Vesta-Token: " + token + "\r\n",
                                                   "X-Vesta-Token:\r\n",
                                                   "Content-Length: 18446744073709551615\r\n",
                                                   "Content-Length: -1\r\n",
                                                   "Content-Length: 3\r\n",
                                                   "Transfer-Encoding: chunked\r\n",
                                                   "Range: bytes=0-,0-,0-,0-\r\n",
                                                   "Range: bytes=9-1\r\n",
                                                   "Expect: 100-continue\r\n",
                                                   "Accept-Encoding: gzip, br\r\n",
                                                   "Content-Type: multipart/form-data; boundary=\r\n",
                                                   "Connection: keep-alive\r\n",
                                                   "Upgrade: h2c\r\n",
                                                   "\r\r\n\n",
                                                   ": \r\n",
                                                   "X: " + std::string(9000, 'x') + "\r\n",
                                                   std::string("X: \0\r\n", 6)};
  if (Below(random, 8) == 0) return Noise(random, 2000);
  std::string text =
      methods[Below(random, methods.size())] + " " + targets[Below(random, targets.size())] + " HTTP/1.1\r\n";
  if (Below(random, 3) > 0) text += "Host: 127.0.0.1\r\n";
  for (std::size_t n = Below(random, 5); n > 0; --n) text += headers[Below(random, headers.size())];
  if (Below(random, 4) > 0) text += "\r\n";
  if (Below(random, 4) == 0) text += "5\r\nhello\r\n0\r\n\r\n";
  if (Below(random, 10) == 0) text.resize(Below(random, text.size()));
  if (Below(random, 10) == 0 && !text.empty()) text[Below(random, text.size())] ^= 0x55;
  return text;
}

std::size_t OpenFiles() {
  const auto all = std::filesystem::directory_iterator("/proc/self/fd");
  return static_cast<std::size_t>(std::distance(begin(all), end(all)));
}

TEST_F(HostileRequests, TenThousandDoNothing) {
  constexpr int kThreads = 8, kEach = 1250;
  const std::size_t files = OpenFiles();
  std::atomic<int> answered{0};
  std::atomic<bool> tells{false};
  std::vector<std::thread> threads;
  threads.reserve(kThreads);
  for (int t = 0; t < kThreads; ++t) {
    threads.emplace_back([&, t] {
      Random random(static_cast<unsigned>(t));
      for (int i = 0; i < kEach; ++i) {
        const test::Reply reply = Ask(server_.port(), Hostile(random, std::string(32, 'a')));
        if (reply.status > 0) ++answered;
        const bool is_refusal = reply.status == 0 || reply.status >= 400 || reply.status == 100;
        if (!is_refusal || reply.body.find("root:") != std::string::npos) tells = true;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_FALSE(tells);
  EXPECT_EQ(done_, 0);
  EXPECT_GT(answered, kThreads * kEach / 2) << "the rest were not valid requests";
  EXPECT_TRUE(IsAlive());
  EXPECT_LE(OpenFiles(), files + 8) << "connections must be closed";
  EXPECT_EQ(Ask(server_.port(), Request("POST", "/stop", server_.token())).status, 200);
  EXPECT_EQ(done_, 1) << "works with the token";
}

// Slow or endless senders are disconnected, and others served meanwhile.
TEST_F(HostileRequests, SlowAndEndlessSendersAreCutOff) {
  std::vector<std::unique_ptr<Connection>> slow;
  for (int i = 0; i < 20; ++i) {
    slow.push_back(std::make_unique<Connection>(server_.port()));
    slow.back()->Send("GET / HT");
  }
  EXPECT_TRUE(IsAlive());
  for (const auto& connection : slow) EXPECT_EQ(connection->Receive().find("200"), std::string::npos);

  const Connection endless(server_.port());
  endless.Send("GET / HTTP/1.1\r\n");
  const std::string header = "X: " + std::string(1000, 'x') + "\r\n";
  std::size_t sent = 0;
  constexpr std::size_t kMuch = 50 << 20;
  while (sent < kMuch && endless.Send(header)) sent += header.size();
  EXPECT_LT(sent, kMuch);
  EXPECT_TRUE(IsAlive());
}

TEST_F(HostileRequests, MoreConnectionsThanThreadsAreClosed) {
  std::vector<std::unique_ptr<Connection>> many;
  for (int i = 0; i < 80; ++i) {
    many.push_back(std::make_unique<Connection>(server_.port()));
    ::usleep(2000);  // the queue of connections to accept is short
  }
  for (std::size_t i = 60; i < many.size(); ++i) EXPECT_EQ(many[i]->Receive(), "");
  many.front()->Send(Request("GET", "/state", server_.token()));
  EXPECT_TRUE(many.front()->Receive().starts_with("HTTP/1.1 200"));
  many.clear();
  bool is_alive = false;
  for (int i = 0; i < 100 && !is_alive; ++i) {
    is_alive = IsAlive();
    if (!is_alive) ::usleep(100000);
  }
  EXPECT_TRUE(is_alive);
}

}  // namespace
}  // namespace vesta::app
