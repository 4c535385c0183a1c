// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/access.h"

#include <gtest/gtest.h>

namespace vesta::app {
namespace {

TEST(Access, TokensDifferAndAreToldApart) {
  const std::string token = MakeToken(), other = MakeToken();
  EXPECT_EQ(token.size(), 32u);
  EXPECT_EQ(token.find_first_not_of("0123456789abcdef"), std::string::npos);
  EXPECT_NE(token, other);
  EXPECT_TRUE(IsToken(token, token));
  EXPECT_FALSE(IsToken(other, token));
  EXPECT_FALSE(IsToken("", token));
  EXPECT_FALSE(IsToken("", ""));
  EXPECT_FALSE(IsToken(token.substr(1), token));
  std::string almost = token;
  almost.back() = almost.back() == '0' ? '1' : '0';
  EXPECT_FALSE(IsToken(almost, token));
}

TEST(Access, OfLoopbackTheHostMustBeOne) {
  for (const char* host : {"127.0.0.1:7007", "localhost:7007", "LOCALHOST:80", "[::1]:7007", "127.0.0.1"}) {
    EXPECT_TRUE(IsOwnPage("127.0.0.1", host, "")) << host;
  }
  // A foreign site could point them to this address.
  for (const char* host :
       {"", "evil.example:7007", "127.0.0.1.evil.example", "localhost.evil.example", "[::2]:7007", ":"}) {
    EXPECT_FALSE(IsOwnPage("127.0.0.1", host, "")) << host;
  }
  EXPECT_TRUE(IsOwnPage("0.0.0.0", "studio.example:7007", ""));
  EXPECT_FALSE(IsOwnPage("0.0.0.0", "", ""));
}

TEST(Access, AnOriginMustBeTheHostsOwn) {
  EXPECT_TRUE(IsOwnPage("127.0.0.1", "localhost:7007", "http://localhost:7007"));
  for (const char* origin : {"http://localhost:7008", "https://localhost:7007", "http://evil.example", "null"}) {
    EXPECT_FALSE(IsOwnPage("127.0.0.1", "localhost:7007", origin)) << origin;
    EXPECT_FALSE(IsOwnPage("0.0.0.0", "localhost:7007", origin)) << origin;
  }
}

}  // namespace
}  // namespace vesta::app
