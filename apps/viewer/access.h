// Who may ask a viewer: whoever holds the token of its link. A page of another site that the same browser has open can
// send requests to a loopback address too, which is why there is a token there as well.
#pragma once

#include <string>
#include <string_view>

namespace vesta::app {

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

}  // namespace vesta::app
