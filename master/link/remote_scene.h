// What the slave says of itself -> what the master needs to know of it.
#pragma once

#include "palpate/v1/scene.pb.h"

#include "master/link/slave_link.h"

namespace palpate {

// Throws std::runtime_error naming the field: a scale, limit, rotation or rate that cannot be.
RemoteScene ToRemoteScene(const v1::SceneDescription& scene, const v1::Capabilities& capabilities);

}  // namespace palpate
