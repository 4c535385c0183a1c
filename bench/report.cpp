// SPDX-License-Identifier: Apache-2.0
#include "bench/report.h"

#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <nlohmann/json.hpp>

#include "bench/commit.h"
#include "kernels/core/check.h"
#include "kernels/core/cpu_dispatch.h"
#include "kernels/core/files.h"
#include "kernels/core/parallel.h"

namespace vesta::bench {
namespace {

std::string CpuModel() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (line.rfind("model name", 0) == 0) return line.substr(line.find(':') + 2);
  }
  return "unknown CPU";
}

std::string Machine() { return fmt::format("{}, {}, {} threads", CpuModel(), IsaName(ActiveIsa()), NumThreads()); }

std::string Text(const Value& value) {
  if (const auto* text = std::get_if<std::string>(&value)) return *text;
  return fmt::format("{:.4g}", std::get<double>(value));
}

nlohmann::ordered_json ToJson(const Row& row) {
  nlohmann::ordered_json object = nlohmann::ordered_json::object();
  for (const auto& [name, value] : row) {
    std::visit([&, key = name](const auto& v) { object[key] = v; }, value);
  }
  return object;
}

}  // namespace

void Report::Finish(const std::string& json_path) const {
  fmt::print("{}: {}\n", bench_, Machine());
  if (!rows_.empty()) {
    std::vector<std::size_t> width;
    for (const auto& [name, value] : rows_.front()) width.push_back(name.size());
    for (const Row& row : rows_) {
      for (std::size_t c = 0; c < row.size() && c < width.size(); ++c) {
        width[c] = std::max(width[c], Text(row[c].second).size());
      }
    }
    for (std::size_t c = 0; c < width.size(); ++c) fmt::print("{:>{}}  ", rows_.front()[c].first, width[c]);
    fmt::print("\n");
    for (const Row& row : rows_) {
      for (std::size_t c = 0; c < row.size() && c < width.size(); ++c)
        fmt::print("{:>{}}  ", Text(row[c].second), width[c]);
      fmt::print("\n");
    }
  }
  for (const Target& t : targets_) {
    fmt::print("target {}: {:.4g} {} (goal {:.4g}) {}\n", t.name, t.value, t.unit, t.goal, t.met ? "met" : "MISSED");
  }
  WriteJson(json_path);
}

void Report::WriteJson(const std::string& json_path) const {
  if (json_path.empty()) return;
  nlohmann::ordered_json json;
  json["bench"] = bench_;
  json["machine"] = Machine();
  json["commit"] = kCommit;
  json["rows"] = nlohmann::ordered_json::array();
  for (const Row& row : rows_) json["rows"].push_back(ToJson(row));
  json["targets"] = nlohmann::ordered_json::array();
  for (const Target& t : targets_) {
    json["targets"].push_back(
        {{"name", t.name}, {"value", t.value}, {"unit", t.unit}, {"goal", t.goal}, {"met", t.met}});
  }
  WriteFileAtomically(json_path, json.dump(2) + "\n");
}

Arguments::Arguments(int argc, char** argv, std::vector<std::string> known) {
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument.rfind("--", 0) != 0) {
      positional.push_back(argument);
      continue;
    }
    const auto equals = argument.find('=');
    const std::string name = argument.substr(2, equals == std::string::npos ? equals : equals - 2);
    if (std::find(known.begin(), known.end(), name) == known.end()) Fail(kBadArgument, "unknown flag --{}", name);
    if (equals == std::string::npos && i + 1 >= argc) Fail(kBadArgument, "--{} needs a value", name);
    flags_.emplace_back(name, equals == std::string::npos ? argv[++i] : argument.substr(equals + 1));
  }
}

std::string Arguments::Flag(const std::string& name, const std::string& fallback) const {
  for (const auto& [key, value] : flags_) {
    if (key == name) return value;
  }
  return fallback;
}

int Arguments::Count(const std::string& name, int fallback) const {
  return ParseCount(name, Flag(name, std::to_string(fallback)));
}

std::vector<std::string> SplitAtCommas(const std::string& text) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    parts.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

int ParseCount(const std::string& flag, const std::string& text) {
  char* end = nullptr;
  const long value = std::strtol(text.c_str(), &end, 10);
  if (text.empty() || *end != 0 || value < 1 || value > 10'000'000) {
    Fail(kBadArgument, "--{}={}: choose a whole number above 0", flag, text);
  }
  return static_cast<int>(value);
}

int ReportErrors(const char* bench, int (*body)(int, char**), int argc, char** argv) {
  try {
    return body(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", bench, error.what());
    return 1;
  }
}

}  // namespace vesta::bench
