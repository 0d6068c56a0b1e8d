#pragma once
/// What every student's file includes, parsed once.
#include <Eigen/Dense>

#include "ch5_backend/homework_missing.h"
#include "ch5_backend/math/psd.h"
#include "ch5_backend/solve/block_diagonal.h"
#include "ch5_backend/solve/problem.h"
#include "ch5_backend/types/edge_se3_prior.h"
#include "ch5_backend/world/mono_ba.h"
