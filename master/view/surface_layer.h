// The deformed surface as coloured faces.
#pragma once

#include "master/link/remote_mesh.h"
#include "master/view/viewpoint.h"
#include "shared/text/svg.h"

namespace palpate {

// Far faces first. Coloured by displacement, `full` [m] > 0 being the darkest, and lit from the
// upper left; coarse meshes are painted in parts of a triangle, so that colours run smoothly.
// What faces the viewer shines through a little: a dent on the far side is seen. Planar objects as
// a coloured outline.
void PaintSurface(const RemoteMesh& mesh, const Viewpoint& view, double full, Svg* drawing);

// The outline at rest in dashes.
void PaintRest(const MeshTopology& topology, const Viewpoint& view, Svg* drawing);

}  // namespace palpate
