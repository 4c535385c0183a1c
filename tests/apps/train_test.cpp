// SPDX-License-Identifier: Apache-2.0
// The program from a scene to its results.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "splatting/io/images/image_file.h"
#include "splatting/io/splats/ply.h"
#include "tests/apps/tiny_training.h"
#include "tests/support/throws_error.h"

namespace vesta::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::UnorderedElementsAre;

TEST_F(TinyTraining, WritesModelAndMetrics) {
  const ProgramOutput output =
      Train(out_, {"--iterations=40", "--lm_iterations=2", "--seed=3", "--sh_degree=1", "--threads=2",
                   "--set=pruning.aic_weight=0", "--set=pruning.sh_aic_weight=0"});
  ASSERT_EQ(output.status, 0) << output.err;
  EXPECT_EQ(output.err, "");
  EXPECT_THAT(output.out, HasSubstr("8 training views, 2 test views (every 8th); 60 points"));
  EXPECT_THAT(output.out, HasSubstr("adam 40/40  training loss "));
  EXPECT_THAT(output.out, HasSubstr("lm   2/2  training loss "));
  EXPECT_THAT(FilesIn(out_), UnorderedElementsAre("point_cloud.ply", "metrics.json", "report.html"));

  const gs::SplatModel model = gs::ReadSplatPly(Ply(out_));
  EXPECT_EQ(model.sh_degree, 1);
  EXPECT_TRUE(model.has_background);
  const json metrics = Metrics(out_);
  EXPECT_THAT(Keys(metrics), UnorderedElementsAre("test", "train", "gaussians", "parameters", "seconds",
                                                  "peak_memory_mib", "memory", "version", "command", "scene", "device",
                                                  "threads", "seed", "preset", "options", "history"));
  const std::string guide = ReadBytes(VESTA_GUIDE "/metrics.md");
  for (const std::string& key : Keys(metrics)) EXPECT_THAT(guide, HasSubstr(fmt::format("`{}`", key)));
  EXPECT_THAT(Keys(metrics["seconds"]), UnorderedElementsAre("load", "adam_end", "lm_end", "eval", "total"));
  EXPECT_EQ(metrics["gaussians"], model.count);
  EXPECT_EQ(metrics["parameters"], model.count * 23);
  EXPECT_EQ(metrics["seed"], 3);
  EXPECT_EQ(metrics["threads"], 2);
  EXPECT_EQ(metrics["command"], "train");
  EXPECT_EQ(metrics["scene"], scene_);
  EXPECT_EQ(metrics["device"], "cpu");
  EXPECT_GT(metrics["peak_memory_mib"], 1.0);
  EXPECT_THAT(Keys(metrics["memory"]),
              UnorderedElementsAre("predicted_mib", "peak_mib", "budget_mib", "jacobian", "batches"));
  EXPECT_EQ(metrics["memory"]["peak_mib"], metrics["peak_memory_mib"]);
  EXPECT_EQ(metrics["memory"]["jacobian"], "on_the_fly");
  ExpectEvalReproduces(out_);
}

TEST_F(TinyTraining, QuietMeansNothingButErrors) {
  const ProgramOutput output = Train(out_, {"--iterations=20", "--quiet"});
  EXPECT_EQ(output.status, 0);
  EXPECT_EQ(output.out, "");
  EXPECT_EQ(output.err, "");
  EXPECT_TRUE(fs::exists(out_ + "/metrics.json"));
  EXPECT_THAT(RunProgram({"train", "nowhere", "--quiet", "--out=" + out_}).err, HasTokens("nowhere"));
}

TEST_F(TinyTraining, EndsAtATargetOnViewsHeldOut) {
  const ProgramOutput output = Train(out_, {"--iterations=40", "--target_psnr=1"});
  ASSERT_EQ(output.status, 0) << output.err;
  EXPECT_THAT(output.out, HasSubstr("7 training views, 1 held out, 2 test views"));
  const json metrics = Metrics(out_);
  ASSERT_EQ(metrics["history"].size(), 1u);
  EXPECT_EQ(metrics["history"][0]["held_out_psnr"], metrics["held_out"]["psnr"]);
  EXPECT_GE(metrics["held_out"]["psnr"], 1.0);
  EXPECT_THAT(RunProgram({"train", scene_, "--out=" + out_, "--target_psnr=-1"}).err, HasTokens("--target_psnr=-1"));
}

TEST_F(TinyTraining, HistoryFollowsBothStages) {
  ASSERT_EQ(Train(out_, {"--iterations=40", "--lm_iterations=2"}).status, 0);
  const json metrics = Metrics(out_);
  std::vector<int> lm_iterations;
  int adam_rows = 0;
  double seconds = metrics["seconds"]["load"];
  for (const json& row : metrics["history"]) {
    EXPECT_THAT(Keys(row), UnorderedElementsAre("stage", "iteration", "seconds", "cost", "train_psnr", "train_ssim",
                                                "test_psnr", "test_ssim", "gaussians"));
    EXPECT_GE(row["seconds"], seconds);
    seconds = row["seconds"];
    if (row["stage"] == "lm") {
      lm_iterations.push_back(row["iteration"]);
    } else {
      ++adam_rows;
    }
  }
  EXPECT_GE(adam_rows, 20);
  EXPECT_THAT(lm_iterations, ElementsAre(0, 1, 2));
  EXPECT_EQ(metrics["history"].back()["test_psnr"], metrics["test"]["psnr"]);
  EXPECT_GE(metrics["seconds"]["adam_end"], metrics["seconds"]["load"]);
  EXPECT_GE(metrics["seconds"]["lm_end"], metrics["seconds"]["adam_end"]);
  EXPECT_GE(metrics["seconds"]["total"], metrics["seconds"]["lm_end"]);
}

TEST_F(TinyTraining, ProfilesWhereAskedAndChangesNothing) {
  const std::string plain = folder_ / "plain";
  const std::vector<std::string> flags = {"--iterations=40", "--lm_iterations=1"};
  ASSERT_EQ(Train(plain, flags).status, 0);
  EXPECT_FALSE(Metrics(plain).contains("profile"));
  EXPECT_THAT(ReadBytes(plain + "/report.html"), Not(HasSubstr("Phases of")));
  const ProgramOutput output = Train(out_, {flags[0], flags[1], "--profile"});
  ASSERT_EQ(output.status, 0) << output.err;
  EXPECT_EQ(ReadBytes(Ply(out_)), ReadBytes(Ply(plain)));
  EXPECT_THAT(output.out, HasSubstr("\nphase "));
  EXPECT_THAT(ReadBytes(out_ + "/report.html"), HasSubstr("Phases of"));
  const json rows = Metrics(out_)["profile"];
  ASSERT_FALSE(rows.empty());
  EXPECT_EQ(rows[0]["phase"], "total");
  double wall = 0, cpu = 0;
  for (const json& row : rows) {
    EXPECT_THAT(Keys(row), UnorderedElementsAre("phase", "depth", "calls", "wall_seconds", "cpu_seconds"));
    if (row["depth"] == 1) wall += row["wall_seconds"].get<double>(), cpu += row["cpu_seconds"].get<double>();
  }
  EXPECT_NEAR(wall, rows[0]["wall_seconds"], 1e-9);
  EXPECT_NEAR(cpu, rows[0]["cpu_seconds"], 1e-9);
}

TEST_F(TinyTraining, FixedModelKeepsThePoints) {
  const std::string grown = folder_ / "grown";
  ASSERT_EQ(Train(out_, {"--iterations=200", "--lm_iterations=0", "--fixed_model"}).status, 0);
  ASSERT_EQ(Train(grown, {"--iterations=200", "--lm_iterations=0"}).status, 0);
  EXPECT_EQ(Metrics(out_)["gaussians"], 60);
  EXPECT_NE(Metrics(grown)["gaussians"], 60);
}

TEST_F(TinyTraining, BackgroundTravelsWithTheModel) {
  ASSERT_EQ(Train(out_, {"--iterations=20", "--lm_iterations=0", "--background=0.25,0.5,1"}).status, 0);
  EXPECT_THAT(gs::ReadSplatPly(Ply(out_)).background, ElementsAre(0.25f, 0.5f, 1.0f));
  ExpectEvalReproduces(out_);
  // A background given by flag takes precedence.
  const std::string file = folder_ / "black.json";
  ASSERT_EQ(RunProgram({"eval", Ply(out_), scene_, "--background=0,0,0", "--json", file}).status, 0);
  EXPECT_NE(json::parse(ReadBytes(file))["test"]["psnr"], Metrics(out_)["test"]["psnr"]);
}

TEST_F(TinyTraining, AntialiasingTravelsWithTheModel) {
  ASSERT_EQ(Train(out_, {"--iterations=20", "--lm_iterations=0", "--antialias"}).status, 0);
  EXPECT_TRUE(gs::ReadSplatPly(Ply(out_)).antialiased);
  ExpectEvalReproduces(out_);
  const std::string file = folder_ / "opaque.json", refined = folder_ / "refined";
  ASSERT_EQ(RunProgram({"eval", Ply(out_), scene_, "--antialias=false", "--json", file}).status, 0);
  EXPECT_NE(json::parse(ReadBytes(file))["test"]["psnr"], Metrics(out_)["test"]["psnr"]);
  for (const bool keeps : {true, false}) {
    std::vector<std::string> words = {"refine", Ply(out_), scene_, "--out=" + refined, "--iterations=10"};
    if (!keeps) words.push_back("--antialias=false");
    ASSERT_EQ(RunProgram(words).status, 0);
    EXPECT_EQ(gs::ReadSplatPly(Ply(refined)).antialiased, keeps);
    ExpectEvalReproduces(refined);
  }
}

TEST_F(TinyTraining, Eps2dTravelsWithTheModel) {
  const ProgramOutput output = Train(out_, {"--iterations=20", "--lm_iterations=0", "--eps2d=0.05"});
  EXPECT_THAT(output.out, HasSubstr("other viewers use 0.3"));
  EXPECT_EQ(gs::ReadSplatPly(Ply(out_)).eps2d, 0.05);
  ExpectEvalReproduces(out_);
  const std::string file = folder_ / "blurred.json", refined = folder_ / "refined";
  ASSERT_EQ(RunProgram({"eval", Ply(out_), scene_, "--eps2d=0.3", "--json", file}).status, 0);
  EXPECT_NE(json::parse(ReadBytes(file))["test"]["psnr"], Metrics(out_)["test"]["psnr"]);
  // Refining keeps eps2d unless told otherwise.
  const auto refine = [&](const std::vector<std::string>& flags) {
    std::vector<std::string> words = {"refine",           Ply(out_),     scene_,
                                      "--out=" + refined, "--method=lm", "--lm_iterations=1"};
    words.insert(words.end(), flags.begin(), flags.end());
    ASSERT_EQ(RunProgram(words).status, 0);
    ExpectEvalReproduces(refined);
  };
  refine({});
  EXPECT_EQ(gs::ReadSplatPly(Ply(refined)).eps2d, 0.05);
  EXPECT_NEAR(Metrics(refined)["history"][0]["train_psnr"].get<double>(), Metrics(out_)["train"]["psnr"], 1e-6);
  refine({"--eps2d=0.3"});
  EXPECT_EQ(gs::ReadSplatPly(Ply(refined)).eps2d, 0.3);
  EXPECT_NEAR(Metrics(refined)["history"][0]["train_psnr"].get<double>(),
              json::parse(ReadBytes(file))["train"]["psnr"].get<double>(), 1e-6);
}

TEST_F(TinyTraining, InterruptWritesWhatThereIs) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    Program program({"train", scene_, "--out=" + out_, "--iterations=20000"});
    ASSERT_TRUE(program.WaitForOutput("adam  1000/20000")) << program.Wait().err;
    program.Signal(signal);
    const ProgramOutput output = program.Wait();
    EXPECT_EQ(output.status, 130) << output.err;
    EXPECT_THAT(output.out, HasSubstr("stopped early"));
    EXPECT_THAT(output.out, HasSubstr("; there is no checkpoint to resume from (--checkpoint_every)\n"));
    EXPECT_EQ(output.err.find("stopping after this iteration") != std::string::npos, signal == SIGINT) << output.err;
    EXPECT_THAT(FilesIn(out_), UnorderedElementsAre("point_cloud.ply", "metrics.json", "report.html"));
    EXPECT_LT(Metrics(out_)["history"].back()["iteration"], 20000);
    ExpectEvalReproduces(out_);
  }
}

TEST_F(TinyTraining, OutputThatNobodyReadsDoesNotEndTheRun) {
  const std::string command =
      fmt::format("{} train {} --out={} --iterations=200 --lm_iterations=0", VESTA_PROGRAM, scene_, out_);
  FILE* pipe = popen(command.c_str(), "r");
  ASSERT_NE(pipe, nullptr);
  ASSERT_NE(std::fgetc(pipe), EOF);
  EXPECT_EQ(pclose(pipe), 0);
  EXPECT_THAT(FilesIn(out_), UnorderedElementsAre("point_cloud.ply", "metrics.json", "report.html"));
}

TEST_F(TinyTraining, TimeLimitEndsTheRunInGoodOrder) {
  const ProgramOutput output = Train(out_, {"--iterations=10000000", "--time_limit=0.5"});
  EXPECT_EQ(output.status, 0) << output.err;
  EXPECT_LT(Metrics(out_)["history"].back()["iteration"], 10000000);
  ExpectEvalReproduces(out_);
}

TEST_F(TinyTraining, RefineBySingleViewsKeepsTheGaussians) {
  ASSERT_EQ(Train(out_, {"--iterations=30", "--lm_iterations=0"}).status, 0);
  const std::string refined = folder_ / "refined";
  const ProgramOutput output = RunProgram({"refine", Ply(out_), scene_, "--out", refined, "--iterations=60"});
  ASSERT_EQ(output.status, 0) << output.err;
  const json metrics = Metrics(refined);
  const json& history = metrics["history"];
  EXPECT_EQ(history[0]["iteration"], 0);
  EXPECT_NEAR(history[0]["test_psnr"], Metrics(out_)["test"]["psnr"].get<double>(), 1e-6) << "the figures of the input";
  EXPECT_EQ(history.back()["stage"], "adam");
  EXPECT_EQ(history.back()["iteration"], 60);
  EXPECT_LT(history.back()["cost"], history[0]["cost"]);
  EXPECT_EQ(metrics["gaussians"], Metrics(out_)["gaussians"]);
  EXPECT_THAT(output.out, HasSubstr("refined: training loss -"));
  ExpectEvalReproduces(refined);
}

TEST_F(TinyTraining, KeepsWhatPaysForItsParameters) {
  const std::string all = folder_ / "all";
  ASSERT_EQ(Train(out_, {"--iterations=100", "--lm_iterations=0"}).status, 0);
  ASSERT_EQ(Train(all, {"--iterations=100", "--lm_iterations=0", "--set=pruning.aic_weight=0",
                        "--set=pruning.sh_aic_weight=0"})
                .status,
            0);
  const json kept = Metrics(out_), before = Metrics(all);
  EXPECT_LT(kept["gaussians"], before["gaussians"]);
  EXPECT_LT(kept["parameters"].get<Index>() * before["gaussians"].get<Index>(),
            before["parameters"].get<Index>() * kept["gaussians"].get<Index>())
      << "fewer parameters per Gaussian too";
  ExpectEvalReproduces(out_);
}

TEST_F(TinyTraining, PruneKeepsAPart) {
  ASSERT_EQ(Train(out_, {"--iterations=60", "--set=pruning.aic_weight=0", "--set=pruning.sh_aic_weight=0",
                         "--set=density.grow_pull=1"})
                .status,
            0);
  const Index all = Metrics(out_)["gaussians"];
  const std::string pruned = folder_ / "pruned";
  const auto prune = [&](const std::string& goal, const std::string& iterations) {
    const ProgramOutput output =
        RunProgram({"prune", Ply(out_), scene_, "--out=" + pruned, goal, "--iterations=" + iterations});
    EXPECT_EQ(output.status, 0) << output.err;
    ExpectEvalReproduces(pruned);
    EXPECT_EQ(Metrics(pruned)["gaussians"], gs::ReadSplatPly(Ply(pruned)).count);
    return output.out;
  };
  const auto count = [&] { return Metrics(pruned)["gaussians"].get<Index>(); };
  const std::string table = prune("--keep=0.5", "40");
  EXPECT_NEAR(static_cast<double>(count()), 0.5 * static_cast<double>(all), 1);
  const json history = Metrics(pruned)["history"];
  EXPECT_EQ(history[0]["gaussians"], all) << "the history begins with the input";
  for (std::size_t i = 1; i < history.size(); ++i) EXPECT_EQ(history[i]["stage"], "adam") << "LM does not run";
  EXPECT_THAT(table, testing::ContainsRegex(fmt::format("\nstart +0 +[0-9.]+ +{} ", all)));
  EXPECT_THAT(table, Not(testing::ContainsRegex("\nlm ")));
  const double gain = 100 * (history.back()["cost"].get<double>() / history[0]["cost"].get<double>() - 1);
  EXPECT_THAT(table, HasSubstr(fmt::format("pruned: training loss {:+.1f} %, ", gain)));
  // Without iterations the model is pruned once, not trained.
  const std::string at_once = prune("--keep=0.5", "0");
  EXPECT_THAT(at_once, HasSubstr(fmt::format("pruned from {} to {} Gaussians in", all, count())));
  EXPECT_THAT(at_once, testing::ContainsRegex(fmt::format("\nstart +0 +[0-9.]+ +{} ", count())));
  const double size = 0.3 * static_cast<double>(fs::file_size(Ply(out_))) / (1 << 20);
  prune(fmt::format("--size_mib={}", size), "0");
  EXPECT_LE(fs::file_size(Ply(pruned)), size * (1 << 20));
  EXPECT_GT(fs::file_size(Ply(pruned)), 0.5 * size * (1 << 20));
  EXPECT_THAT(prune("--max_loss=0.1", "0"), HasSubstr("training loss 1.0"));
  EXPECT_LT(count(), all);
  // Refining keeps all Gaussians, even if --config enables pruning.
  prune("--keep=0.5", "30");
  const Index half = count();
  ASSERT_EQ(
      RunProgram({"refine", Ply(pruned), scene_, "--out=" + folder_ / "again", "--config=" + pruned + "/metrics.json"})
          .status,
      0);
  EXPECT_EQ(Metrics(folder_ / "again")["gaussians"].get<Index>(), half);
}

TEST_F(TinyTraining, RefineLowersTheCost) {
  ASSERT_EQ(Train(out_, {"--iterations=30", "--lm_iterations=0"}).status, 0);
  const std::string refined = folder_ / "refined";
  const ProgramOutput output =
      RunProgram({"refine", Ply(out_), scene_, "--out", refined, "--method=lm", "--lm_iterations=2"});
  ASSERT_EQ(output.status, 0) << output.err;
  const json history = Metrics(refined)["history"];
  ASSERT_EQ(history.size(), 3u);
  EXPECT_NEAR(history[0]["test_psnr"], Metrics(out_)["test"]["psnr"].get<double>(), 1e-6);
  EXPECT_LT(history[2]["cost"], history[0]["cost"]);
  EXPECT_GT(history[2]["train_psnr"], history[0]["train_psnr"]);
  ExpectEvalReproduces(refined);
  const json metrics = Metrics(refined);
  EXPECT_EQ(metrics["train"]["psnr"], history[2]["train_psnr"]);
  EXPECT_THAT(output.out,
              HasSubstr(fmt::format("refined: training loss {:+.1f} %, train PSNR {:+.3f} dB",
                                    100 * (history[2]["cost"].get<double>() / history[0]["cost"].get<double>() - 1),
                                    history[2]["train_psnr"].get<double>() - history[0]["train_psnr"].get<double>())));
}

// From another program: another SH degree, and no background in the file.
TEST_F(TinyTraining, RefineTakesTheModelAsItIs) {
  ASSERT_EQ(Train(out_, {"--iterations=30", "--lm_iterations=0", "--sh_degree=1", "--background=0.25,0.5,1",
                         "--set=pruning.sh_aic_weight=0"})
                .status,
            0);
  gs::SplatModel model = gs::ReadSplatPly(Ply(out_));
  model.has_background = false;
  const std::string foreign = folder_ / "foreign.ply", refined = folder_ / "refined";
  gs::WriteSplatPly(foreign, model);
  const auto start_psnr = [&](const std::vector<std::string>& flags) {
    std::vector<std::string> words = {"refine",           foreign,       scene_,
                                      "--out=" + refined, "--method=lm", "--lm_iterations=1"};
    words.insert(words.end(), flags.begin(), flags.end());
    const ProgramOutput output = RunProgram(words);
    EXPECT_EQ(output.status, 0) << output.err;
    ExpectEvalReproduces(refined);
    return Metrics(refined)["history"][0]["train_psnr"].get<double>();
  };
  const double trained_psnr = Metrics(out_)["train"]["psnr"];
  EXPECT_GT(std::abs(start_psnr({}) - trained_psnr), 0.01) << "over black";
  EXPECT_NEAR(start_psnr({"--background=0.25,0.5,1"}), trained_psnr, 1e-6);
  const gs::SplatModel result = gs::ReadSplatPly(Ply(refined));
  EXPECT_EQ(result.sh_degree, 1);
  EXPECT_EQ(result.count, model.count);
  EXPECT_THAT(result.background, ElementsAre(0.25f, 0.5f, 1.0f));
}

TEST_F(TinyTraining, WarnsOfASplatOfAnotherFrame) {
  constexpr const char* kDoubt = "in the same frame";
  ASSERT_EQ(Train(out_, {"--iterations=100", "--lm_iterations=0"}).status, 0);
  EXPECT_EQ(RunProgram({"eval", Ply(out_), scene_}).out.find(kDoubt), std::string::npos);
  gs::SplatModel model = gs::ReadSplatPly(Ply(out_));
  for (Index i = 0; i < model.count; ++i) model.attribute(0)[i] += 100;  // outside all views
  const std::string moved = folder_ / "moved.ply";
  gs::WriteSplatPly(moved, model);
  EXPECT_THAT(RunProgram({"eval", moved, scene_}).out, HasSubstr(kDoubt));
  EXPECT_THAT(RunProgram({"refine", moved, scene_, "--out=" + (folder_ / "refined"), "--lm_iterations=1"}).out,
              HasSubstr(kDoubt));
}

TEST_F(TinyTraining, RefineByNoIterationsChangesNothing) {
  ASSERT_EQ(Train(out_, {"--iterations=10", "--lm_iterations=0"}).status, 0);
  const std::string refined = folder_ / "refined";
  ASSERT_EQ(RunProgram({"refine", Ply(out_), scene_, "--out=" + refined, "--iterations=0"}).status, 0);
  EXPECT_TRUE(ReadBytes(Ply(refined)) == ReadBytes(Ply(out_)));
}

// Each LM option in its own run. A memory budget of 1 GiB changes nothing; 1 MiB is refused.
TEST_F(TinyTraining, EveryWayOfLmLowersTheCost) {
  ASSERT_EQ(Train(out_, {"--iterations=30", "--lm_iterations=0"}).status, 0);
  const std::string refined = folder_ / "refined";
  const std::vector<std::vector<std::string>> ways = {
      {"--set=lm.jacobian=cache16", "--memory_budget=1"},
      {"--set=lm.jacobian=cached_views"},
      {"--set=lm.preconditioner=block"},
      {"--set=lm.batches=2", "--set=lm.batch_size=2", "--set=lm.batch_choice=random", "--set=lm.merge_batches=true"},
      {"--preset=paper"},
      {"--preset=paper_code"}};
  for (const auto& way : ways) {
    SCOPED_TRACE(testing::PrintToString(way));
    std::vector<std::string> arguments = {"refine",      Ply(out_),          scene_, "--out", refined,
                                          "--method=lm", "--lm_iterations=1"};
    arguments.insert(arguments.end(), way.begin(), way.end());
    const ProgramOutput output = RunProgram(arguments);
    ASSERT_EQ(output.status, 0) << output.err;
    const json history = Metrics(refined)["history"];
    EXPECT_LT(history.back()["cost"], history[0]["cost"]);
  }
  const ProgramOutput output = RunProgram({"refine", Ply(out_), scene_, "--out", refined, "--memory_budget=0.001"});
  EXPECT_EQ(output.status, 1);
  EXPECT_THAT(output.err, HasTokens("--memory_budget=0.001"));
}

TEST_F(TinyTraining, RenderWritesTheTestViews) {
  ASSERT_EQ(Train(out_, {"--iterations=5", "--lm_iterations=0"}).status, 0);
  const std::string plain = folder_ / "plain", both = folder_ / "both";
  ASSERT_EQ(RunProgram({"render", Ply(out_), scene_, "--out=" + plain}).status, 0);
  ASSERT_EQ(RunProgram({"render", Ply(out_), scene_, "--out=" + both, "--truth"}).status, 0);
  EXPECT_THAT(FilesIn(plain), UnorderedElementsAre("000.png", "008.png"));
  EXPECT_THAT(FilesIn(both), UnorderedElementsAre("000.png", "008.png"));
  const gs::Image truth = gs::LoadImage(scene_ + "/images/008.png");
  const gs::Image render = gs::LoadImage(plain + "/008.png"), pair = gs::LoadImage(both + "/008.png");
  ASSERT_EQ(pair.width, 2 * kTinyWidth);
  ASSERT_EQ(pair.height, kTinyHeight);
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < kTinyHeight; ++y) {
      for (int x = 0; x < kTinyWidth; ++x) {
        const float* row = pair.plane(c) + y * pair.width;
        ASSERT_EQ(row[x], render.plane(c)[y * kTinyWidth + x]);
        ASSERT_EQ(row[kTinyWidth + x], truth.plane(c)[y * kTinyWidth + x]);
      }
    }
  }
}

}  // namespace
}  // namespace vesta::test
