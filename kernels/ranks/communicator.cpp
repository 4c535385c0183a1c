// SPDX-License-Identifier: Apache-2.0
#include "kernels/ranks/communicator.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <initializer_list>
#include <system_error>

#include "kernels/core/check.h"
#include "kernels/core/profile.h"

namespace vesta {

template <class Exchange>
void Communicator::Count(std::span<const std::size_t> sizes, const Exchange& exchange) {
  const ScopedPhase phase("exchange");
  VESTA_CHECK(static_cast<int>(sizes.size()) == size(), "got {} pieces for {} ranks", sizes.size(), size());
  ++traffic_.exchanges;
  for (std::size_t r = 0; r < sizes.size(); ++r) {
    if (static_cast<int>(r) != rank()) traffic_.bytes += static_cast<std::int64_t>(sizes[r]);
  }
  const auto begin = std::chrono::steady_clock::now();
  exchange();
  traffic_.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

void Communicator::AllGather(Bytes all, std::span<const std::size_t> sizes) {
  const std::int64_t before = traffic_.bytes;
  Count(sizes, [&] { DoAllGather(all, sizes); });
  traffic_.gathered += traffic_.bytes - before;
}

void Communicator::AllToAll(ConstBytes send, std::span<const std::size_t> send_sizes, Bytes receive,
                            std::span<const std::size_t> receive_sizes) {
  Count(receive_sizes, [&] { DoAllToAll(send, send_sizes, receive, receive_sizes); });
}

void SingleRankCommunicator::DoAllToAll(ConstBytes send, std::span<const std::size_t> send_sizes, Bytes receive,
                                        std::span<const std::size_t> receive_sizes) {
  VESTA_CHECK(send_sizes[0] == receive_sizes[0], "a rank sends {} bytes to itself but receives {}", send_sizes[0],
              receive_sizes[0]);
  std::copy_n(send.begin(), send_sizes[0], receive.begin());
}

namespace {

// Returns the numbers in the first of these environment variables that starts with a number. "2(x3),1" gives 2 and 1.
std::vector<int> NumbersFrom(std::initializer_list<const char*> names) {
  for (const char* name : names) {
    const char* at = std::getenv(name);
    std::vector<int> numbers;
    while (at != nullptr) {
      const char* const end = at + std::strlen(at);
      int number = 0;
      const auto [after, error] = std::from_chars(at, end, number);
      if (error != std::errc() || number < 1) break;
      numbers.push_back(number);
      const char* const comma = std::find(after, end, ',');
      at = comma == end ? nullptr : comma + 1;
    }
    if (!numbers.empty()) return numbers;
  }
  return {1};
}

}  // namespace

// Set by Open MPI, by MPICH and other launchers with PMI, and by Slurm with PMIx.
bool IsStartedInRanks() {
  const auto names = {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_RANK"};
  return std::ranges::any_of(names, [](const char* name) { return std::getenv(name) != nullptr; });
}

int NumStartedRanks() {
  return IsStartedInRanks() ? NumbersFrom({"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "SLURM_NTASKS"}).front() : 1;
}

int NumRanksOnThisMachine() {
  if (!IsStartedInRanks()) return 1;
  // Slurm lists the number for each machine, but not which of them this one is.
  const auto names = {"OMPI_COMM_WORLD_LOCAL_SIZE", "MPI_LOCALNRANKS", "SLURM_STEP_TASKS_PER_NODE"};
  return std::ranges::max(NumbersFrom(names));
}

std::vector<std::string> GatherStrings(Communicator& ranks, const std::string& mine) {
  const std::vector<std::size_t> lengths = GatherValues(ranks, std::vector<std::size_t>{mine.size()});
  const std::vector<char> letters = GatherValues(ranks, std::vector<char>(mine.begin(), mine.end()));
  std::vector<std::string> words;
  words.reserve(lengths.size());
  std::size_t at = 0;
  for (const std::size_t length : lengths) {
    words.emplace_back(letters.data() + at, length);
    at += length;
  }
  return words;
}

bool OnAnyRank(Communicator& ranks, bool mine) {
  if (ranks.size() == 1) return mine;
  const std::vector<char> all = GatherValues(ranks, std::vector<char>{static_cast<char>(mine)});
  return std::any_of(all.begin(), all.end(), [](char any) { return any != 0; });
}

}  // namespace vesta
