// SPDX-License-Identifier: Apache-2.0
// The parts of a report, and pages made from unusual records.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "apps/inputs/scene_and_splat.h"
#include "apps/report/error_map.h"
#include "apps/report/html.h"
#include "apps/report/page.h"
#include "kernels/core/error.h"
#include "tests/apps/html_check.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"

namespace vesta::app {
namespace {

using test::HtmlFaults;
using test::PageText;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::Pair;

TEST(Html, EscapesWhatMeansSomething) {
  EXPECT_EQ(Escape("<a href=\"x\" title='y'> & so on"), "&lt;a href=&quot;x&quot; title=&#39;y&#39;&gt; &amp; so on");
  EXPECT_EQ(Escape("caf\xc3\xa9 \xe2\x82\xac \xf0\x9f\x8c\xb5"), "caf\xc3\xa9 \xe2\x82\xac \xf0\x9f\x8c\xb5");
  EXPECT_EQ(Escape(""), "");
}

TEST(Html, ReplacesWhatIsNoText) {
  const std::string replacement = "\xef\xbf\xbd";
  // A single byte, a missing byte, an overlong encoding, a surrogate, a code point beyond the last, control characters.
  for (const std::string bad : {"\xff", "\x80", "\xc3", "\xc0", "\x01", "\x7f", "\xc2\x85"}) {
    EXPECT_EQ(Escape("a" + bad), "a" + replacement) << testing::PrintToString(bad);
  }
  EXPECT_EQ(Escape("\xe2\x82"), replacement + replacement);
  EXPECT_EQ(Escape("\xc0\xbc"
                   "script"),
            replacement + replacement + "script")
      << "an overlong < is not a tag";
  EXPECT_EQ(Escape("\xed\xa0\x80"), replacement + replacement + replacement);
  EXPECT_EQ(Escape("\xf4\x90\x80\x80"), replacement + replacement + replacement + replacement);
  EXPECT_EQ(Escape(std::string("a\0b", 3)), "a" + replacement + "b");
}

TEST(Html, Base64IsThatOfItsStandard) {  // RFC 4648, section 10
  EXPECT_EQ(DataUri("text/plain", ""), "data:text/plain;base64,");
  EXPECT_EQ(DataUri("a", "f"), "data:a;base64,Zg==");
  EXPECT_EQ(DataUri("a", "fo"), "data:a;base64,Zm8=");
  EXPECT_EQ(DataUri("a", "foo"), "data:a;base64,Zm9v");
  EXPECT_EQ(DataUri("a", "foobar"), "data:a;base64,Zm9vYmFy");
  EXPECT_EQ(DataUri("a", "\xff\xfe\xfb"), "data:a;base64,//77");
}

gs::Image Grey(float value) {
  gs::Image image(10, 10);
  for (float& channel : image.rgb) channel = value;
  return image;
}

TEST(ErrorMap, IsBlackWhereThereIsNone) {
  gs::Image render = Grey(0.5f);
  const gs::Image truth = render;
  for (int c = 0; c < 3; ++c) render.plane(c)[7] = 1.0f;
  const gs::Image map = ErrorMap(render, truth);
  EXPECT_LT(map.plane(0)[0] + map.plane(1)[0] + map.plane(2)[0], 0.05f);
  EXPECT_GT(map.plane(0)[7] + map.plane(1)[7] + map.plane(2)[7], 2.0f);
  EXPECT_THROW(ErrorMap(render, gs::Image(10, 9)), Error);
}

TEST(ErrorMap, KnowsInHowFewPixelsHalfOfItIs) {
  gs::Image render = Grey(0.5f);
  EXPECT_EQ(FractionWithHalfOfError(render, Grey(0.5f)), 0);
  EXPECT_NEAR(FractionWithHalfOfError(render, Grey(0.6f)), 0.5, 1e-12) << "the same error everywhere";
  const gs::Image truth = render;
  render.plane(1)[3] = 0.9f;
  EXPECT_NEAR(FractionWithHalfOfError(render, truth), 0.005, 1e-12) << "half of one pixel out of 100";
}

// With masks, the report has the figures of the training's evaluation, from unmasked pixels only.
TEST(ViewErrors, AreOfThePixelsThatCount) {
  const gs::SplatModel model = gs::test::RandomModel(40, 0, 1);
  gs::Scene scene = gs::test::RingOfCameras(8, 48, 32, true);
  gs::test::RenderTruth(gs::test::Perturbed(model, 0.05, 2), 0, &scene);
  for (gs::View& view : scene.views) {
    view.image.mask.resize(view.image.num_pixels());
    for (std::size_t i = 0; i < view.image.mask.size(); ++i) {
      view.image.mask[i] = i % 48 < 24 ? 1 : 0;
      for (int c = 0; c < 3 && view.image.mask[i] == 0; ++c) view.image.plane(c)[i] = 0.9f;
    }
  }
  gs::Renderer renderer(ToDouble(model.background), gs::NearPlane(scene));
  const gs::Evaluation evaluation = renderer.Evaluate(model, scene);
  const std::vector<ViewError> errors = ViewRenderer(model, scene).Measure();
  ASSERT_EQ(errors.size(), 1u);
  EXPECT_DOUBLE_EQ(errors[0].quality.psnr, evaluation.test.psnr);
  EXPECT_DOUBLE_EQ(errors[0].quality.ssim, evaluation.test.ssim);
  // Only the unmasked half.
  const gs::Image& photograph = scene.views[0].image;
  const gs::Image compared = gs::ToCompare(renderer.Render(model, scene.views[0]), photograph);
  EXPECT_EQ(compared.plane(0)[30], photograph.plane(0)[30]);
  EXPECT_NE(compared.plane(0)[48 * 16 + 12], photograph.plane(0)[48 * 16 + 12]);
  EXPECT_DOUBLE_EQ(errors[0].half_error_fraction, 2 * FractionWithHalfOfError(compared, photograph));
}

TEST(SvgChart, MarksAreRoundAndWithin) {
  EXPECT_THAT(RoundMarks(0, 10, 5), ElementsAre(0, 2, 4, 6, 8, 10));
  EXPECT_THAT(RoundMarks(18.3, 31.2, 5), ElementsAre(20, 25, 30));
  EXPECT_THAT(RoundMarks(-1, 1, 2), ElementsAre(-1, 0, 1));
  EXPECT_EQ(ShortNumber(0.25, 0.05), "0.25");
  EXPECT_EQ(ShortNumber(120000, 20000), "120k");
  EXPECT_EQ(ShortNumber(1500000, 500000), "1.5M");
  EXPECT_EQ(ShortNumber(0, 0.1), "0");
}

TEST(SvgChart, LeavesOutWhatIsNotFinite) {
  const std::string chart =
      ToSvg({"<title>", "x", {{"a & b", 0, false, {{0, 1}, {1, NAN}, {2, 3}, {NAN, 3}, {3, INFINITY}}}}});
  EXPECT_THAT(HtmlFaults("<!DOCTYPE html>" + chart), IsEmpty());
  EXPECT_EQ(test::AttributeValues(chart, "circle", "r").size(), 2u);
  EXPECT_THAT(chart, Not(HasSubstr("nan")));
  EXPECT_THAT(chart, Not(HasSubstr("inf")));
  EXPECT_THAT(ToSvg({"t", "x", {{"", 0, false, {{NAN, NAN}}}}}), HasSubstr("no data"));
  EXPECT_THAT(ToSvg({"t", "x", {}}), HasSubstr("no data"));
  EXPECT_THAT(ToSvg({"t", "x", {{"", 0, false, {{2, 2}}}}}), Not(HasSubstr("nan"))) << "a single point";
}

TEST(RunRecord, WhatIsMissingIsNotKnown) {
  EXPECT_THROW(RunRecord("run", "no JSON", 0), Error);
  EXPECT_THROW(RunRecord("run", "[1]", 0), Error);
  const RunRecord empty("run", "{}", 0);
  EXPECT_TRUE(std::isnan(empty.Number("test.psnr")));
  EXPECT_EQ(empty.Text("scene"), "");
  EXPECT_THAT(empty.notes(), IsEmpty());
  EXPECT_THAT(empty.History("cost"), IsEmpty());
  const RunRecord odd("run", R"({"test": 3, "notes": [1, "one"], "history": [{"cost": 1}, 7, {"cost": "x"}],
                                 "options": {"adam": {"iterations_scale": "auto", "rate": 0.5}, "lm": 3}, "scene": 4})",
                      0);
  EXPECT_TRUE(std::isnan(odd.Number("test.psnr")));
  EXPECT_EQ(odd.Text("scene"), "");
  EXPECT_THAT(odd.notes(), ElementsAre("one"));
  EXPECT_THAT(odd.History("cost"), ElementsAre(1, testing::IsNan(), testing::IsNan()));
  EXPECT_THAT(odd.Options(), ElementsAre(Pair("adam.iterations_scale", "auto"), Pair("adam.rate", "0.5")));
}

Report WithoutScenes(const std::vector<std::string>& metrics, const std::string& name) {
  std::vector<RunSource> runs;
  runs.reserve(metrics.size());
  for (const std::string& text : metrics) runs.push_back({RunRecord(name, text, 0), "nowhere"});
  return GatherReport(std::move(runs), [](std::size_t) -> PosedSplat { throw Error(kNotFound, "<b>lost</b>"); });
}

TEST(ReportPage, IsSoundWithoutAnything) {
  const std::string page = ReportPage(WithoutScenes({"{}"}, "run"));
  EXPECT_THAT(HtmlFaults(page), IsEmpty());
  EXPECT_THAT(PageText(page), HasSubstr("Its test views are not shown: <b>lost</b>"));
  EXPECT_THAT(PageText(page), Not(HasSubstr("nan")));
  EXPECT_THAT(HtmlFaults(ReportPage(WithoutScenes({"{}", "{}", "{}"}, "run"))), IsEmpty());
}

// Text from files never becomes markup.
TEST(ReportPage, EscapesAllThatFilesSay) {
  const std::string evil = R"(\"'><script>alert(1)</script><img src=x onerror=alert(2)>&lt;)";
  const std::string shown = R"("'><script>alert(1)</script><img src=x onerror=alert(2)>&lt;)";
  std::string metrics = R"({"scene": "E", "command": "E", "preset": "E", "device": "E", "version": "E", "notes": ["E"],
    "options": {"adam": {"E": "E"}}, "profile": [7, {"phase": 8}, {"phase": "E", "depth": "E", "wall_seconds": 3}],
    "history": [{"seconds": 1, "cost": 2, "E": 3}, {"seconds": 2, "cost": 1}]})";
  for (std::size_t at = metrics.find("\"E\""); at != std::string::npos; at = metrics.find("\"E\"")) {
    metrics.replace(at + 1, 1, evil);
  }
  const std::string page = ReportPage(WithoutScenes({metrics, metrics}, shown));
  EXPECT_THAT(HtmlFaults(page), IsEmpty());
  EXPECT_EQ(page.find("<script>alert"), std::string::npos);
  EXPECT_EQ(page.find("<img src=x"), std::string::npos);
  EXPECT_THAT(PageText(page), HasSubstr(shown)) << "and shown as text";
}

TEST(ReportPage, ShowsFiguresAndWhatDiffers) {
  const std::string one = R"({"test": {"psnr": 27.125, "ssim": 0.87654}, "gaussians": 1234567, "preset": "balanced",
                              "options": {"adam": {"iterations": 40, "length": 76}, "train": {"seed": 0}}})";
  const std::string other = R"({"test": {"psnr": 28.5, "ssim": null}, "preset": "balanced",
                                "options": {"adam": {"iterations": 80, "length": 76}, "train": {"seed": 0}}})";
  const std::string text = PageText(ReportPage(WithoutScenes({one, other}, "run")));
  EXPECT_THAT(text, HasSubstr("27.12"));
  EXPECT_THAT(text, HasSubstr("28.50"));
  EXPECT_THAT(text, HasSubstr("0.8765"));
  EXPECT_THAT(text, HasSubstr("1,234,567"));
  const std::size_t differs = text.find("adam.iterations"), rest = text.find("All other settings");
  EXPECT_LT(differs, rest);
  EXPECT_LT(rest, text.find("train.seed"));
}

}  // namespace
}  // namespace vesta::app
