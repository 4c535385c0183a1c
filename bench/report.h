// SPDX-License-Identifier: Apache-2.0
// The output of every benchmark: a table, also written as JSON with --json FILE; and parsing of its arguments.
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
  // All rows should have the same columns; the headings come from the first row.
  void Add(Row row) { rows_.push_back(std::move(row)); }
  void AddTarget(Target target) { targets_.push_back(std::move(target)); }

  // Writes {"bench", "machine", "commit", "rows", "targets"} of everything added so far as JSON. An empty path writes
  // nothing. The file is replaced atomically. Throws Error if it cannot be written.
  void WriteJson(const std::string& json_path) const;
  // Prints the table on standard output, then calls WriteJson.
  void Finish(const std::string& json_path) const;

 private:
  std::string bench_;
  std::vector<Row> rows_;
  std::vector<Target> targets_;
};

// Median wall-clock milliseconds of `repeats` calls, after one untimed call.
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

// Command-line arguments: flags --name=VALUE or --name VALUE. Arguments that do not begin with -- are positional.
// Throws Error for a flag that is not in `known`.
struct Arguments {
  Arguments(int argc, char** argv, std::vector<std::string> known);
  std::string Flag(const std::string& name, const std::string& fallback) const;
  // Value of the flag, parsed by ParseCount.
  int Count(const std::string& name, int fallback) const;

  std::vector<std::string> positional;

 private:
  std::vector<std::pair<std::string, std::string>> flags_;
};

// Splits "a,b,c" into its parts; returns none for "".
std::vector<std::string> SplitAtCommas(const std::string& text);
// Parses a whole number from 1 to 10 million. Throws an Error that names the flag for any other text.
int ParseCount(const std::string& flag, const std::string& text);

// Body of main: runs `body` and returns its status. An exception is printed in one line on stderr, after the
// benchmark's name, and gives status 1.
int ReportErrors(const char* bench, int (*body)(int, char**), int argc, char** argv);

}  // namespace vesta::bench
