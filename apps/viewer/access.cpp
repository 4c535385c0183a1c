#include "apps/viewer/access.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <sys/random.h>

#include <array>
#include <cctype>
#include <cstdint>

#include "kernels/core/check.h"

namespace vesta::app {
namespace {

// "127.0.0.1" of "127.0.0.1:7007", "::1" of "[::1]:7007".
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
    Fail("the system gives no random numbers for the viewer's token");
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

}  // namespace vesta::app
