#pragma once
#include <gtest/gtest.h>

#include "ch5_homework/judge/compiled_products.h"

#include "ch5_backend/math/precompiled.h"
