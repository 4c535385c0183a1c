// SPDX-License-Identifier: Apache-2.0
// Common parts of the benchmarks: a table, which --json FILE also writes as JSON, and the command line.
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

// Whether `value` meets a goal.
struct Target {
  std::string name;
  double value = 0;
  std::string unit;
  double goal = 0;
  bool met = false;
};

class Report {
 public:
  // bench: its name.
  explicit Report(std::string bench) : bench_(std::move(bench)) {}
  // Pairs of column name and value. All rows should have the columns of the first one.
  void Add(Row row) { rows_.push_back(std::move(row)); }
  void AddTarget(Target target) { targets_.push_back(std::move(target)); }

  // Writes all rows and targets so far as JSON: {"bench", "machine", "commit", "rows", "targets"}. Replaces an existing
  // file atomically. Does nothing for an empty path. Throws Error if the file cannot be written.
  void WriteJson(const std::string& json_path) const;
  // Prints the table, then calls WriteJson.
  void Finish(const std::string& json_path) const;

 private:
  std::string bench_;
  std::vector<Row> rows_;
  std::vector<Target> targets_;
};

// The median of at least one value; for an even number the upper of the two middle values.
inline double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Median wall-clock time of `repeats` calls of body, in milliseconds, after an untimed one.
template <class Body>
double MedianMilliseconds(int repeats, const Body& body) {
  body();
  std::vector<double> times(static_cast<std::size_t>(repeats));
  for (double& time : times) {
    const auto begin = std::chrono::steady_clock::now();
    body();
    time = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  }
  return Median(std::move(times));
}

// Flags --name=VALUE or --name VALUE, and positional arguments, which do not begin with --.
struct Arguments {
  // known: flags without --. Throws Error for another flag or one without a value.
  Arguments(int argc, char** argv, std::vector<std::string> known);
  // `fallback` if it is not given.
  std::string Flag(const std::string& name, const std::string& fallback) const;
  // The same, parsed by ParseCount.
  int Count(const std::string& name, int fallback) const;

  std::vector<std::string> positional;

 private:
  std::vector<std::pair<std::string, std::string>> flags_;
};

// "a,b,c" at the commas; none for "".
std::vector<std::string> SplitAtCommas(const std::string& text);
// A whole number from 1 to 10 million. Throws Error (one line with the flag) for any other text.
int ParseCount(const std::string& flag, const std::string& text);

// Returns the exit status of `body`, the main function of a benchmark. If it throws, prints the benchmark's name and
// the message as one line on stderr and returns 1.
int ReportErrors(const char* bench, int (*body)(int, char**), int argc, char** argv);

}  // namespace vesta::bench
