#pragma once
/// Does it pay on a recording that the estimator models the noise of a host's observation (types/visual/edge_track.h)?
/// Whole tracks carry no loss, so the losses of the single residuals are left out too, lest two things change at once.

#include "ch5_backend/files/tables/csv.h"
#include "ch5_backend/types/recording.h"

namespace ch5 {

/// A row a policy and way to take hosts: "exact with loss", which is the default, "exact" and "noisy".
/// @param name  of the recording, in the table
void AppendHostNoise(const std::string& name, const Recording& recording, CsvTable* table);
/// The table without rows.
CsvTable HostNoiseTable();

}  // namespace ch5
