// SPDX-License-Identifier: Apache-2.0
// Ranks from the environment variables of mpirun and Slurm.
#include <gtest/gtest.h>

#include <cstdlib>
#include <map>
#include <string>

#include "kernels/ranks/communicator.h"

namespace vesta {
namespace {

class StartedRanks : public testing::Test {
 protected:
  static constexpr const char* kNames[] = {"OMPI_COMM_WORLD_SIZE",
                                           "OMPI_COMM_WORLD_LOCAL_SIZE",
                                           "OMPI_COMM_WORLD_LOCAL_RANK",
                                           "PMI_SIZE",
                                           "MPI_LOCALNRANKS",
                                           "MPI_LOCALRANKID",
                                           "PMIX_RANK",
                                           "SLURM_NTASKS",
                                           "SLURM_LOCALID",
                                           "SLURM_STEP_TASKS_PER_NODE"};

  StartedRanks() {
    for (const char* name : kNames) {
      if (const char* value = std::getenv(name)) before_[name] = value;
      unsetenv(name);
    }
  }
  ~StartedRanks() override {
    for (const char* name : kNames) unsetenv(name);
    for (const auto& [name, value] : before_) setenv(name.c_str(), value.c_str(), 1);
  }
  static void Set(const char* name, const char* value) { setenv(name, value, 1); }

 private:
  std::map<std::string, std::string> before_;
};

TEST_F(StartedRanks, AreOneWithoutALauncher) {
  EXPECT_FALSE(IsStartedInRanks());
  EXPECT_EQ(NumStartedRanks(), 1);
  EXPECT_EQ(NumRanksOnThisMachine(), 1);
  // The script of a batch job is no rank, although its job has tasks.
  Set("SLURM_NTASKS", "4"), Set("SLURM_LOCALID", "2");
  EXPECT_EQ(NumStartedRanks(), 1);
}

TEST_F(StartedRanks, AreReadFromMpirun) {
  Set("OMPI_COMM_WORLD_SIZE", "6"), Set("OMPI_COMM_WORLD_LOCAL_SIZE", "3"), Set("OMPI_COMM_WORLD_LOCAL_RANK", "2");
  EXPECT_TRUE(IsStartedInRanks());
  EXPECT_EQ(NumStartedRanks(), 6);
  EXPECT_EQ(NumRanksOnThisMachine(), 3);
}

// `mpirun -n 1` in a job of four tasks.
TEST_F(StartedRanks, AreReadFromMpirunBeforeSlurm) {
  Set("OMPI_COMM_WORLD_SIZE", "1"), Set("OMPI_COMM_WORLD_LOCAL_SIZE", "1"), Set("OMPI_COMM_WORLD_LOCAL_RANK", "0");
  Set("SLURM_NTASKS", "4"), Set("SLURM_LOCALID", "3"), Set("SLURM_STEP_TASKS_PER_NODE", "2(x2)");
  EXPECT_EQ(NumStartedRanks(), 1);
  EXPECT_EQ(NumRanksOnThisMachine(), 1);
}

TEST_F(StartedRanks, AreReadFromSlurm) {
  Set("PMIX_RANK", "5"), Set("SLURM_NTASKS", "7"), Set("SLURM_LOCALID", "1");
  for (const auto& [said, most] : {std::pair("2(x3),1", 2), std::pair("1,3(x2)", 3), std::pair("4", 4)}) {
    Set("SLURM_STEP_TASKS_PER_NODE", said);
    EXPECT_EQ(NumRanksOnThisMachine(), most) << said;
  }
  EXPECT_EQ(NumStartedRanks(), 7);
}

TEST_F(StartedRanks, IgnoreVariablesThatAreNoNumber) {
  Set("OMPI_COMM_WORLD_SIZE", "many"), Set("OMPI_COMM_WORLD_LOCAL_RANK", "-3"), Set("OMPI_COMM_WORLD_LOCAL_SIZE", "");
  EXPECT_EQ(NumStartedRanks(), 1);
  EXPECT_EQ(NumRanksOnThisMachine(), 1);
}

}  // namespace
}  // namespace vesta
