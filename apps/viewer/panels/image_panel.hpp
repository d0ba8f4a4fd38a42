#pragma once

#include <map>

#include "viewer/scene/scene.hpp"

namespace hgros::viewer {

/// A window for each display with an image: as large as fits, with the value under the pointer. The wheel zooms, a drag
/// moves, a double click shows the whole image again.
class ImagePanel {
 public:
  void Draw(const Scene& scene);

 private:
  /// The visible part of an image.
  struct Part {
    float zoom = 1;  ///< 1: the whole image.
    float middle_x = 0.5F, middle_y = 0.5F;
  };
  void DrawImage(const ShownImage& image, Part& part);

  std::map<const Display*, Part> parts_;
};

}  // namespace hgros::viewer
