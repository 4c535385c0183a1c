#include "bench/training_race/variants.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "problems/gaussian_splatting/train/fit_to_scene.h"

namespace vesta::bench {
namespace {

// All fields as one text.
std::string TextOf(const gs::TrainOptions& options) {
  std::string text;
  for (const auto& field : gs::TrainFields()) text += field.name + "=" + field.Text(options) + "\n";
  return text;
}

// As the bench makes it.
gs::TrainOptions Reference() {
  gs::TrainOptions options = gs::FitToScene(gs::PresetOptions("balanced"), 20);
  options.lm.iterations = 8;
  return options;
}

// From a reference that has none of their values.
TEST(Variants, EachChangesWhatItIsOf) {
  gs::TrainOptions reference = Reference();
  reference.lm.pcg_iterations = 5;
  for (const Variant& variant : Variants(reference, 1)) {
    EXPECT_EQ(TextOf(variant.options) == TextOf(reference), variant.knob == "reference")
        << variant.knob << ", " << variant.name;
  }
}

TEST(Variants, EachHasAName) {
  std::set<std::string> names;
  for (const Variant& variant : Variants(Reference(), 1)) {
    EXPECT_TRUE(names.insert(variant.knob + ", " + variant.name).second) << variant.knob << ", " << variant.name;
    EXPECT_NO_THROW(gs::ValidateOptions(variant.options)) << variant.knob << ", " << variant.name;
  }
}

TEST(Variants, ReferenceIsFirstAndAsGiven) {
  gs::TrainOptions reference = Reference();
  reference.lm.pcg_iterations = 5;
  const std::vector<Variant> variants = Variants(reference, 1);
  EXPECT_EQ(variants[0].knob, "reference");
  EXPECT_EQ(variants[0].options.lm.pcg_iterations, 5);
  for (const Variant& variant : variants) {
    EXPECT_EQ(variant.options.lm.pcg_iterations == 5, variant.knob != "PCG iterations" && variant.knob != "preset");
  }
}

// As many views as the time of both stages allows, whatever the batch.
TEST(Variants, AdamAloneHasTheWholeTime) {
  const gs::TrainOptions reference = Reference();
  int found = 0;
  for (const Variant& variant : Variants(reference, 0.5)) {
    EXPECT_EQ(variant.from_points, variant.knob == "no LM" || variant.knob == "when to switch") << variant.name;
    if (variant.knob != "no LM") continue;
    ++found;
    const gs::AdamOptions& adam = variant.options.adam;
    EXPECT_EQ(variant.options.lm.iterations, 0);
    EXPECT_NEAR(*adam.iterations, 1.5 * *reference.adam.iterations, 1) << "counted in views";
    EXPECT_EQ(adam.rate_factor, reference.adam.rate_factor);
  }
  EXPECT_EQ(found, 3);
}

}  // namespace
}  // namespace vesta::bench
