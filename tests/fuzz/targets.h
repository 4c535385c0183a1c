// SPDX-License-Identifier: Apache-2.0
// What is fuzzed: one function a target, each in target_NAME.cpp, its seeds in corpus/NAME. libFuzzer feeds them by
// fuzz_main.cpp, the ordinary tests by corpus_test.cpp. All throw Finding, or whatever else it is that must not be
// thrown, where a promise does not hold.
#pragma once

#include <string_view>

namespace vesta::fuzz {

// Files, as their readers meet them.
void FuzzBal(std::string_view bytes);
void FuzzCheckpoint(std::string_view bytes);  // without what stands before the state, and the checksum
void FuzzColmap(std::string_view bytes);      // a digit chooses one of the six files, the rest is that file
void FuzzCompressedPly(std::string_view bytes);
void FuzzConfig(std::string_view bytes);
void FuzzG2o(std::string_view bytes);
void FuzzImage(std::string_view bytes);  // JPEG, or PNG with any checksums
void FuzzNerf(std::string_view bytes);   // transforms.json
void FuzzPointPly(std::string_view bytes);
void FuzzSplatPly(std::string_view bytes);
void FuzzSpz(std::string_view bytes);  // before compression, a line "vesta..." for the comment; or compressed

// Whether a checkpoint is read down to where the training came from, and to the model of LM's stage.
bool ReadsCheckpoint(std::string_view bytes);

// One word a line.
void FuzzCommandLine(std::string_view bytes);

// A few Gaussians in a small view (target_operators.cpp has how they lie in the bytes).
void FuzzOperators(std::string_view bytes);

}  // namespace vesta::fuzz
