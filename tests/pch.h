#pragma once
#include <gtest/gtest.h>

#include "ch5_backend/math/precompiled.h"
#include "tests/compiled_products.h"
