#pragma once
/// Slides of a window as a film: what stands in H and what leaves it, the prior that remains, and how certain the frames are.

#include <filesystem>
#include <memory>
#include <vector>

#include "ch5_backend/files/tables/csv.h"
#include "ch5_backend/files/tables/text_writer.h"
#include "ch5_backend/types/recording.h"
#include "ch5_backend/window/policy.h"

namespace ch5 {

/// film_blocks    the largest entry of each block on or below the diagonal that is not zero, of H before the slide and of the
///                prior after it. `fill`: the slide has made it, H had none there; window_row, window_column: where the
///                prior's block stands in H
/// film_vertices  whose rows those of H are, and what the slide makes of them
/// film_frames    the window's frames from above, laid upon the truth at the oldest one, with the covariance that they claim
///                relative to it, and where they truly were; the truth at the images
struct FilmTables {
  CsvTable blocks{"policy,image,case,stage,size,row,rows,column,columns,largest,fill,window_row,window_column"};
  CsvTable vertices{"policy,image,case,vertex,number,keyframe,row,rows,fate"};
  CsvTable frames{"policy,image,t_s,frame,x_m,y_m,true_x_m,true_y_m,xx_m2,xy_m2,yy_m2"};
  double seconds = 0.0;  ///< spent on them

  /// Where the camera truly was at each image.
  void AppendTruth(const Recording& recording);
  void AddTo(const std::filesystem::path& csv, FileBatch* files) const;
};

/// The policy, whose slides after every `every`-th image are told to the tables; of OKVIS's, the first one in which a keyframe
/// leaves and the first in which another frame does bear that as their `case`.
/// @param recorded  the truth, or empty: then frames are where they are estimated;  @param recorded, tables  must outlive it
std::unique_ptr<WindowPolicy> Filmed(std::unique_ptr<WindowPolicy> policy, const std::vector<StampedState>& recorded,
                                     int every, FilmTables* tables);

}  // namespace ch5
