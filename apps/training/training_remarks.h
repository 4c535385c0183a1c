// What there is to say of the result of a training, beside its figures.
#pragma once

#include <string>
#include <vector>

#include "apps/training/training_job.h"

namespace vesta::app {

// A line each: where the splat lies, what it is to be shown with, how to measure it, memory beyond what was asked for.
// result: of the job, its model in the scene's world. splat: the file that it is written to.
std::vector<std::string> RemarksOn(const TrainingJob& job, const gs::TrainResult& result, const std::string& splat);

// Of a training that was stopped by who watches it: how to go on; else nothing. Of the process that writes.
std::string HowToGoOn(const TrainingJob& job, const gs::TrainResult& result);

}  // namespace vesta::app
