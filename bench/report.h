// SPDX-License-Identifier: Apache-2.0
// What every benchmark prints: a table, and with --json FILE the same as JSON.
#pragma once

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace vesta::bench {

using Value = std::variant<std::string, double>;
using Row = std::vector<std::pair<std::string, Value>>;

struct Target {
  std::string name;
  double value = 0;
  std::string unit;
  double goal = 0;
  bool met = false;
};

class Report {
 public:
  explicit Report(std::string bench) : bench_(std::move(bench)) {}
  // Rows should have the same columns; the first row's names head the table.
  void Add(Row row) { rows_.push_back(std::move(row)); }
  void AddTarget(Target target) { targets_.push_back(std::move(target)); }

  // Unless the path is empty, JSON {"bench", "machine", "commit", "rows", "targets"} of all that was added so far,
  // written whole to the file. Throws Error where it cannot be written.
  void WriteJson(const std::string& json_path) const;
  // The table on standard output; then WriteJson.
  void Finish(const std::string& json_path) const;

 private:
  std::string bench_;
  std::vector<Row> rows_;
  std::vector<Target> targets_;
};

// Median wall-clock milliseconds of `repeats` calls, after one that is not counted.
template <class Body>
double MedianMilliseconds(int repeats, const Body& body) {
  body();
  std::vector<double> times(static_cast<std::size_t>(repeats));
  for (double& time : times) {
    const auto begin = std::chrono::steady_clock::now();
    body();
    time = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  }
  std::nth_element(times.begin(), times.begin() + repeats / 2, times.end());
  return times[static_cast<std::size_t>(repeats / 2)];
}

// The value of --name=VALUE or --name VALUE, or the default; arguments that do not begin with -- are positional.
struct Arguments {
  Arguments(int argc, char** argv, std::vector<std::string> known);
  std::string Flag(const std::string& name, const std::string& fallback) const;
  // The flag as ParseCount reads it.
  int Count(const std::string& name, int fallback) const;

  std::vector<std::string> positional;

 private:
  std::vector<std::pair<std::string, std::string>> flags_;
};

// "a,b,c" as its parts; none for "".
std::vector<std::string> SplitAtCommas(const std::string& text);
// A whole number from 1 to 10 million. Throws Error, naming the flag, for anything else.
int ParseCount(const std::string& flag, const std::string& text);

// The body of main: runs `body`. An exception becomes one line on stderr after the benchmark's name, and status 1.
int ReportErrors(const char* bench, int (*body)(int, char**), int argc, char** argv);

}  // namespace vesta::bench
