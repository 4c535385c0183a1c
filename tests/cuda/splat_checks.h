// Views, the loss and the splatting problem of a device against those of the host: what holds on a GPU, and on the
// device that tests/support/emulated_device makes of the host.
#pragma once

namespace vesta::test {

// Images, products and Gram blocks of DeviceView.
void ExpectViewsOfTheHost();
// Value, gradient and W of DevicePhotometricLoss, for each SsimLinearization.
void ExpectLossOfTheHost();
// Cost, gradient, diagonal, metric, blocks and products of DeviceSplatProblem.
void ExpectProblemOfTheHost();
// The same with sampled pixels, a cached Jacobian, batches, blocks of the colours and the root of SSIM.
void ExpectVariantsOfTheHost();

}  // namespace vesta::test
