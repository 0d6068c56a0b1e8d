#pragma once
/// What this machine can do at most with the registers that CH5_SIMD allows, for a roofline.

namespace ch5::bench {

/// Fused multiply-adds on numbers in registers, one thread [GFLOP/s].
double PeakGflops();

/// Numbers read in order from an array of so many megabytes, one thread [GB/s].
double ReadBandwidth(double megabytes);

}  // namespace ch5::bench
