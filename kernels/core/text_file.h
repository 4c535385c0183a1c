// Reading of text files whose contents are not trusted.
#pragma once

#include <string>
#include <string_view>

#include "kernels/core/span.h"

namespace vesta {

// False, too, where the path cannot be looked up (no permission, a name too long for the system).
bool FileExists(const std::string& path);
bool FolderExists(const std::string& path);

// The whole file. Throws Error when it is missing, not a regular file, or cannot be read.
std::string ReadFile(const std::string& path);

// Parses a whole word as a number (nan and inf included); false where it is not a number or out of range.
bool ParseNumber(std::string_view word, double* value);
bool ParseNumber(std::string_view word, Index* value);

// Cuts the first line off `text`, without its end, which the last need not have; false where there is nothing left.
bool NextLine(std::string_view* text, std::string_view* line);
// Without the white space around it.
std::string_view Trimmed(std::string_view line);

// The next word of `text`, which is cut off at its front together with the white space before it; empty at the end.
std::string_view NextWord(std::string_view* text);

// A piece of a file for a message: at most 60 characters, and '?' in place of all that is not printable ASCII.
std::string Printable(std::string_view text);

}  // namespace vesta
