#pragma once
/// The grader's precompiled header of a student's file: the headers that the homework includes. With the products of
/// compiled_products.h such a file compiles in a second in place of two or three.

#include "ch5_homework/judge/told_sizes.h"  // before Eigen

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <set>

#include "ch5_backend/consistency/gauge_freedom.h"
#include "ch5_backend/dense/block_diagonal.h"
#include "ch5_backend/dense/blocks/plain_block_solver.h"
#include "ch5_backend/dense/problem.h"
#include "ch5_backend/homework_missing.h"
#include "ch5_backend/marginalize/marginalization_error.h"
#include "ch5_backend/marginalize/marginalization_info.h"
#include "ch5_backend/marginalize/square_root.h"
#include "ch5_backend/math/psd.h"
#include "ch5_backend/open_tasks/open_tasks.h"
#include "ch5_backend/simulate/mono_ba.h"
#include "ch5_backend/types/edge_se3_prior.h"
#include "ch5_backend/types/vertices.h"
#include "ch5_backend/window/landmarks.h"
#include "ch5_backend/window/vins_window.h"
#include "ch5_homework/judge/compiled_products.h"
