// SPDX-License-Identifier: Apache-2.0
// The program in several processes, started with mpirun.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/collections/generate_bundle.h"
#include "problems/bundle_adjustment/bal_file.h"
#include "tests/apps/run_program.h"
#include "tests/apps/tiny_scene.h"
#include "tests/support/throws_error.h"

namespace vesta::test {
namespace {

using testing::HasSubstr;

// For mpirun to run the command in `count` processes.
std::vector<std::string> On(int count, std::vector<std::string> command) {
  std::vector<std::string> arguments{"-n", std::to_string(count)};
  arguments.insert(arguments.end(), command.begin(), command.end());
  return arguments;
}
std::vector<std::string> Vesta(int count, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), VESTA_UNDER_MPI);
  return On(count, arguments);
}
// Error lines by vesta itself.
int Complaints(const std::string& err) {
  int count = 0;
  for (std::size_t at = err.find("vesta: "); at != std::string::npos; at = err.find("vesta: ", at + 1)) ++count;
  return count;
}

class UnderMpi : public testing::Test {
 protected:
  void SetUp() override {
    // For more processes than cores, and for root in a container. Other MPIs ignore them.
    setenv("OMPI_MCA_rmaps_base_oversubscribe", "1", 1);
    setenv("OMPI_ALLOW_RUN_AS_ROOT", "1", 1);
    setenv("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1", 1);
  }
  void WriteProblem(Index points = 200) {
    bundle::WriteBal(in_, bundle::Generate({.num_cameras = 12, .num_points = points, .mean_track = 4}));
  }
  std::vector<std::string> Adjust(int count, const std::string& out) {
    return Vesta(count, {"bundle_adjust", in_, "--out=" + out, "--threads=1"});
  }
  // Two processes: rank 0 reads in0.txt, rank 1 in1.txt.
  ProgramOutput AdjustOwnFiles() {
    const std::string command = "exec " VESTA_UNDER_MPI " bundle_adjust " + (folder_ / "in") +
                                "${OMPI_COMM_WORLD_RANK:-$PMI_RANK}.txt --out=" + (folder_ / "out.txt");
    return RunProgram(On(2, {"sh", "-c", command}));
  }

  TempFolder folder_;
  std::string in_ = folder_ / "in.txt";
};

TEST_F(UnderMpi, AdjustsToTheSameFileOnAnyNumberOfProcesses) {
  WriteProblem();
  const std::string alone = folder_ / "1.txt";
  ASSERT_EQ(RunProgram(Adjust(1, alone)).status, 0);
  for (const int count : {2, 3, 4}) {
    const std::string out = folder_ / (std::to_string(count) + ".txt");
    const ProgramOutput output = RunProgram(Adjust(count, out));
    EXPECT_EQ(output.status, 0) << output.err;
    EXPECT_TRUE(ReadBytes(out) == ReadBytes(alone)) << count << " processes";
    // Only one process prints.
    EXPECT_EQ(output.out.find("reprojection error"), output.out.rfind("reprojection error"));
  }
}

TEST_F(UnderMpi, RefinesToTheSameSplatOnAnyNumberOfProcesses) {
  WriteTinyScene(folder_ / "scene");
  const std::string start = folder_ / "start";
  ASSERT_EQ(
      RunProgram(Vesta(1, {"train", folder_ / "scene", "--out=" + start, "--iterations=30", "--noreport"})).status, 0);
  std::string alone;
  for (const int count : {1, 2, 3}) {
    const std::string out = folder_ / ("refined" + std::to_string(count));
    const ProgramOutput output =
        RunProgram(Vesta(count, {"refine", start + "/point_cloud.ply", folder_ / "scene", "--out=" + out,
                                 "--iterations=0", "--lm_iterations=2", "--threads=1", "--noreport"}));
    ASSERT_EQ(output.status, 0) << output.err;
    const std::string splat = ReadBytes(out + "/point_cloud.ply");
    if (count == 1) alone = splat;
    EXPECT_TRUE(splat == alone) << count << " processes";
    EXPECT_FALSE(splat == ReadBytes(start + "/point_cloud.ply"));
  }
}

TEST_F(UnderMpi, TrainsToTheSameSplatOnAnyNumberOfProcesses) {
  WriteTinyScene(folder_ / "scene");
  std::string alone;
  for (const int count : {1, 2, 3, 4}) {
    const std::string out = folder_ / ("trained" + std::to_string(count));
    const ProgramOutput output =
        RunProgram(Vesta(count, {"train", folder_ / "scene", "--out=" + out, "--iterations=120", "--threads=1", "--set",
                                 "adam.batch_size=3", "--lm_iterations=1", "--noreport", "--profile"}));
    EXPECT_EQ(output.out.find("\nphase "), output.out.rfind("\nphase ")) << "only rank 0 prints one";
    EXPECT_NE(output.out.find("\nphase "), std::string::npos);
    ASSERT_EQ(output.status, 0) << output.err;
    const std::string splat = ReadBytes(out + "/point_cloud.ply");
    if (count == 1) alone = splat;
    EXPECT_TRUE(splat == alone) << count << " processes";
    const nlohmann::json processes = nlohmann::json::parse(ReadBytes(out + "/metrics.json"))["processes"];
    EXPECT_EQ(processes["count"], count);
    EXPECT_EQ(processes["received_mib"] > 0.0, count > 1);
    EXPECT_GT(processes["exchange_seconds"], 0.0);
  }
  // Adam gives the same result without mpirun.
  const auto by_adam = [&](const std::string& name, bool is_under_mpi) {
    const std::string out = folder_ / name;
    std::vector<std::string> arguments{"train",       folder_ / "scene", "--out=" + out,      "--iterations=120",
                                       "--threads=1", "--set",           "adam.batch_size=3", "--noreport"};
    if (is_under_mpi) {
      EXPECT_EQ(RunProgram(Vesta(2, arguments)).status, 0);
    } else {
      std::string command = "unset OMPI_COMM_WORLD_SIZE PMI_SIZE PMIX_RANK; exec " VESTA_UNDER_MPI;
      for (const std::string& argument : arguments) command += " " + argument;
      EXPECT_EQ(RunProgram(On(1, {"sh", "-c", command})).status, 0);
    }
    return ReadBytes(out + "/point_cloud.ply");
  };
  EXPECT_TRUE(by_adam("adam2", true) == by_adam("adam", false));
}

TEST_F(UnderMpi, SaysWhatIsWrongForAllOnce) {
  const ProgramOutput output = RunProgram(Adjust(3, folder_ / "out.txt"));
  EXPECT_NE(output.status, 0);
  EXPECT_EQ(Complaints(output.err), 1) << output.err;
  EXPECT_THAT(output.err, HasTokens("0", "3", "in.txt"));
}

TEST_F(UnderMpi, EndsAllWhereOneFails) {
  WriteProblem();
  std::filesystem::copy_file(in_, folder_ / "in0.txt");
  // Only rank 1 finds no file.
  const ProgramOutput output = AdjustOwnFiles();
  EXPECT_NE(output.status, 0);
  EXPECT_EQ(Complaints(output.err), 1) << output.err;
  EXPECT_THAT(output.err, HasTokens("1", "2", "in1.txt"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out.txt"));
}

TEST_F(UnderMpi, RefusesProblemsThatDiffer) {
  WriteProblem();
  std::filesystem::copy_file(in_, folder_ / "in0.txt");
  WriteProblem(201);
  std::filesystem::copy_file(in_, folder_ / "in1.txt");
  const ProgramOutput output = AdjustOwnFiles();
  EXPECT_NE(output.status, 0);
  EXPECT_THAT(output.err, HasTokens("0", "1"));
}

TEST_F(UnderMpi, LeavesNothingHalfDoneWhereOneIsKilled) {
  WriteProblem(60000);
  const std::string command =
      "if [ ${OMPI_COMM_WORLD_RANK:-$PMI_RANK} = 1 ]; then (sleep 0.2; kill -9 $$) & fi; exec " +
      std::string(VESTA_UNDER_MPI) + " bundle_adjust " + in_ + " --out=" + (folder_ / "out.txt") +
      " --iterations=100000 --threads=1";
  std::ofstream(folder_ / "out.txt") << "as it was";
  const ProgramOutput output = RunProgram(On(2, {"sh", "-c", command}));
  EXPECT_NE(output.status, 0);
  EXPECT_TRUE(ReadBytes(folder_ / "out.txt") == "as it was");
}

TEST_F(UnderMpi, EndsTogetherAtATimeLimit) {
  WriteProblem(5000);
  std::vector<std::string> arguments = Adjust(2, folder_ / "out.txt");
  arguments.emplace_back("--time_limit=0.01");
  const ProgramOutput output = RunProgram(arguments);
  EXPECT_EQ(output.status, 0) << output.err;
  EXPECT_THAT(output.out, HasSubstr("time limit"));
  EXPECT_THAT(output.out, HasSubstr("wrote"));
}

TEST_F(UnderMpi, TrainsForATime) {
  WriteTinyScene(folder_ / "scene");
  const ProgramOutput output =
      RunProgram(Vesta(2, {"train", folder_ / "scene", "--out=" + (folder_ / "out"), "--time_limit=1", "--threads=1",
                           "--set", "adam.batch_size=2", "--noreport"}));
  EXPECT_EQ(output.status, 0) << output.err;
  EXPECT_THAT(output.out, HasSubstr("metrics.json"));
}

TEST_F(UnderMpi, RefusesWhatSeveralProcessesCannotDo) {
  WriteTinyScene(folder_ / "scene");
  const auto refusal = [&](int count, const std::vector<std::string>& arguments) {
    const ProgramOutput output = RunProgram(Vesta(count, arguments));
    EXPECT_NE(output.status, 0);
    EXPECT_EQ(Complaints(output.err), 1) << output.err;  // although every process detects it
    return output.err;
  };
  const std::string scene = folder_ / "scene", out = "--out=" + (folder_ / "out");
  EXPECT_THAT(refusal(2, {"doctor", scene}), HasTokens("doctor", "mpirun"));
  EXPECT_THAT(refusal(2, {"train", scene, out, "--memory_budget=0.001"}), HasTokens("--memory_budget=0.001", "mpirun"));
  EXPECT_THAT(refusal(2, {"train", scene, out, "--view=8123"}), HasTokens("--view"));
  EXPECT_THAT(refusal(2, {"train", scene, out, "--iterations=30", "--refine_cameras=pose"}),
              HasSubstr("--refine_cameras=pose: only one process can refine cameras, not 2"));
  EXPECT_THAT(refusal(9, {"train", scene, out, "--iterations=2", "--lm_iterations=1"}), HasTokens("9", "8"));
  EXPECT_THAT(refusal(2, {"train", scene, out, "--iterations=2", "--lm_iterations=1", "--set", "lm.batches=2"}),
              HasTokens("lm.batches=1"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out/point_cloud.ply"));
}

}  // namespace
}  // namespace vesta::test
