#pragma once
/// What a student's file needs most, parsed once. No more: each inline function here is compiled with every file.
#include "ch5_homework/judge/told_sizes.h"  // before Eigen

#define CH5_SMALL_PRODUCTS
#include "ch5_homework/judge/compiled_products.h"

#include "ch5_backend/dense/block_diagonal.h"
#include "ch5_backend/dense/problem.h"
#include "ch5_backend/homework_missing.h"
#include "ch5_backend/math/precompiled.h"
#include "ch5_backend/math/psd.h"
