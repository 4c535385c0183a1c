// The texts that flags may be set to.
#pragma once

#include <array>
#include <string>

#include "apps/flags.h"

namespace vesta::app {

// Throws UsageError, one line that names the flag, the text and what is allowed, where the text is no value of the
// flag: another type, out of range, no such choice.
void CheckFlagValue(const FlagRule& rule, const std::string& text);

// "R,G,B", each in 0..1. Returns false for anything else.
bool ParseColor(const std::string& text, std::array<float, 3>* color);

// What stands after "=" in the help: N, X, a|b, R,G,B; empty for a switch.
std::string ValuePlaceholder(const FlagRule& rule);

}  // namespace vesta::app
