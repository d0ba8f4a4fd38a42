#pragma once

#include <map>

#include "viewer/scene/scene.hpp"

namespace hgros::viewer {

/// A window for each display that has an image: as large as fits, with the value under the pointer. The wheel zooms,
/// a drag moves, a double click shows all of it again.
class ImagePanel {
 public:
  void Draw(const Scene& scene);

 private:
  /// What of an image is seen.
  struct Part {
    float zoom = 1;  ///< 1: all of it.
    float middle_x = 0.5F, middle_y = 0.5F;
  };
  void DrawImage(const ShownImage& image, Part& part);

  std::map<const Display*, Part> parts_;
};

}  // namespace hgros::viewer
