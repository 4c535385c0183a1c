// The manual, for `man`.
#pragma once

#include <string>

namespace vesta::app {

// Section 1, in the language of man (roff), made from the tables of commands, flags and options.
std::string ManPage();

}  // namespace vesta::app
