// SPDX-License-Identifier: Apache-2.0
// The fuzz targets: one function each in target_NAME.cpp, with seeds in corpus/NAME. libFuzzer calls them through
// fuzz_main.cpp, the ordinary tests through corpus_test.cpp. They throw Finding, or an unexpected exception, if an
// invariant is violated.
#pragma once

#include <string_view>

namespace vesta::fuzz {

// File contents, as the readers get them.
void FuzzAntimatterSplat(std::string_view bytes);
void FuzzBal(std::string_view bytes);
void FuzzCheckpoint(std::string_view bytes);  // without magic number, version and checksum
void FuzzColmap(std::string_view bytes);      // a digit selects one of six files; the rest is its content
void FuzzCompressedPly(std::string_view bytes);
void FuzzConfig(std::string_view bytes);
void FuzzG2o(std::string_view bytes);
void FuzzImage(std::string_view bytes);   // JPEG, or PNG with any checksums
void FuzzKsplat(std::string_view bytes);  // without the unused bytes of the headers
void FuzzNerf(std::string_view bytes);    // transforms.json
void FuzzPointPly(std::string_view bytes);
void FuzzSog(std::string_view bytes);  // meta.json in a line, then its images; or a zip archive
void FuzzSplatPly(std::string_view bytes);
void FuzzSpz(std::string_view bytes);  // uncompressed, after an optional line "vesta..." for the comment; or compressed
void FuzzSpzStreams(std::string_view bytes);  // version 4

// Whether it can be read up to its origin and, in the LM stage, its model.
bool ReadsCheckpoint(std::string_view bytes);

// One argument per line.
void FuzzCommandLine(std::string_view bytes);

// A few Gaussians in a small view (layout of the bytes: target_operators.cpp).
void FuzzOperators(std::string_view bytes);

}  // namespace vesta::fuzz
