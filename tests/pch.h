#pragma once
#include <gtest/gtest.h>

#include "ch5_backend/math/eigen_types.h"
