# What is installed, and the Debian packages that deploy/package.sh makes of it. Components: slave, master, cameras, dev, python.
# `cmake --install build/release --prefix /usr` installs what runs, without packages; DESTDIR packs it. EXCLUDE_FROM_ALL: in
# packages only.
set(palpate_packages ${CMAKE_SOURCE_DIR}/deploy/packages)
set(palpate_made ${CMAKE_BINARY_DIR}/package)  # what deploy/package.sh generates

# palpate_unit(FILE FOLDER COMPONENT): a systemd unit that starts what stands below the prefix.
function(palpate_unit file folder component)
  cmake_path(GET file FILENAME name)
  install(CODE "
    file(READ \"${file}\" text)
    string(REPLACE \"=/usr/\" \"=\${CMAKE_INSTALL_PREFIX}/\" text \"\${text}\")
    file(WRITE \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/lib/systemd/${folder}/${name}\" \"\${text}\")"
    COMPONENT ${component})
endfunction()
palpate_unit(${CMAKE_SOURCE_DIR}/deploy/palpate-slave.service system slave)
palpate_unit(${palpate_packages}/palpate-master.service user master)

install(DIRECTORY deploy/scenes deploy/fingertips DESTINATION share/palpate COMPONENT slave PATTERN "*.md" EXCLUDE PATTERN "heart-target.py" EXCLUDE
        PATTERN "liver-press.msh" EXCLUDE PATTERN "__pycache__" EXCLUDE)
install(FILES ${palpate_packages}/sysusers.conf DESTINATION lib/sysusers.d RENAME palpate.conf COMPONENT slave)
install(PROGRAMS deploy/certs DESTINATION bin RENAME palpate-certs COMPONENT slave EXCLUDE_FROM_ALL)
install(FILES deploy/udev/60-palpate.rules DESTINATION lib/udev/rules.d COMPONENT master)
foreach(component slave master)
  install(FILES ${palpate_packages}/${component}/${component}.conf DESTINATION /etc/palpate COMPONENT ${component} EXCLUDE_FROM_ALL)
  install(DIRECTORY ${palpate_made}/${component}/ DESTINATION share COMPONENT ${component} EXCLUDE_FROM_ALL)
endforeach()

# A C++ client: find_package(Palpate) gives Palpate::proto, the generated messages and stubs.
include(CMakePackageConfigHelpers)
set_target_properties(palpate_proto PROPERTIES EXPORT_NAME proto)
install(TARGETS palpate_proto EXPORT PalpateTargets ARCHIVE DESTINATION lib COMPONENT dev EXCLUDE_FROM_ALL)
install(EXPORT PalpateTargets NAMESPACE Palpate:: DESTINATION lib/cmake/Palpate COMPONENT dev EXCLUDE_FROM_ALL)
write_basic_package_version_file(PalpateConfigVersion.cmake COMPATIBILITY SameMajorVersion)
install(FILES ${palpate_packages}/PalpateConfig.cmake ${CMAKE_BINARY_DIR}/PalpateConfigVersion.cmake
  DESTINATION lib/cmake/Palpate COMPONENT dev EXCLUDE_FROM_ALL)
install(DIRECTORY ${CMAKE_BINARY_DIR}/proto/palpate DESTINATION include COMPONENT dev EXCLUDE_FROM_ALL
  FILES_MATCHING PATTERN "*.h" PATTERN "recording.*" EXCLUDE)
install(DIRECTORY proto/ DESTINATION share/palpate/proto COMPONENT dev EXCLUDE_FROM_ALL FILES_MATCHING PATTERN "*.proto")

install(DIRECTORY ${palpate_made}/python/palpate DESTINATION lib/python3/dist-packages COMPONENT python EXCLUDE_FROM_ALL
        PATTERN "__pycache__" EXCLUDE)

foreach(component slave master cameras dev python)
  set(package palpate-${component})
  if(component STREQUAL python)
    set(package python3-palpate)
  endif()
  install(FILES ${palpate_packages}/copyright ${palpate_made}/changelog.gz DESTINATION share/doc/${package}
    COMPONENT ${component} EXCLUDE_FROM_ALL OPTIONAL)  # deploy/package.sh makes the second
  string(TOUPPER ${component} COMPONENT)
  set(CPACK_DEBIAN_${COMPONENT}_PACKAGE_NAME ${package})
  file(GLOB scripts ${palpate_packages}/${component}/p*inst ${palpate_packages}/${component}/p*rm ${palpate_packages}/${component}/conffiles)
  set(CPACK_DEBIAN_${COMPONENT}_PACKAGE_CONTROL_EXTRA ${scripts})
endforeach()

set(CPACK_GENERATOR DEB)
set(CPACK_COMPONENTS_ALL slave master cameras dev python)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_SET_DESTDIR ON)  # for /etc
set(CPACK_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_PACKAGE_CONTACT "Palpate developers <palpate@packages.invalid>")
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_SOURCE palpate)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_DEV_PACKAGE_SHLIBDEPS OFF)
set(CPACK_DEBIAN_SLAVE_PACKAGE_DEPENDS "libopenblas0-pthread, systemd | systemd-standalone-sysusers | systemd-sysusers")
set(CPACK_DEBIAN_SLAVE_PACKAGE_RECOMMENDS "palpate-cameras, openssl")
set(CPACK_DEBIAN_SLAVE_PACKAGE_SUGGESTS "palpate-master, python3")
set(CPACK_DEBIAN_CAMERAS_PACKAGE_DEPENDS "gstreamer1.0-plugins-base")
set(CPACK_DEBIAN_CAMERAS_PACKAGE_RECOMMENDS "palpate-slave")
set(CPACK_DEBIAN_MASTER_PACKAGE_SUGGESTS "libspnav0, spacenavd")
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "libgrpc++-dev, libprotobuf-dev, protobuf-compiler-grpc")
# The module is for the Python whose headers it was compiled with.
get_directory_property(minor DIRECTORY deploy/python/core DEFINITION Python3_VERSION_MINOR)
if(minor)
  math(EXPR next "${minor} + 1")
endif()
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3 (>= 3.${minor}~), python3 (<< 3.${next}), libopenblas0-pthread, libzstd1, python3-grpcio, python3-numpy, python3-protobuf")
set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "gmsh, python3-matplotlib")

set(CPACK_COMPONENT_SLAVE_DESCRIPTION "Palpate slave: contact force without a force sensor
Observes a soft object with cameras or tactile fingertips, computes the contact
force with a physics model, and streams both over gRPC. Needs no display.")
set(CPACK_COMPONENT_MASTER_DESCRIPTION "Palpate master: renders the contact force of a slave
Connects to a palpate-slave and renders its contact force at 1 kHz on a haptic
device, or on a page with the mouse.")
set(CPACK_COMPONENT_CAMERAS_DESCRIPTION "Palpate slave: cameras, videos and depth cameras
Modules of palpate-slave for cameras, streams, videos, depth cameras, and image
formats other than PNG and JPEG.")
set(CPACK_COMPONENT_DEV_DESCRIPTION "Palpate: messages and stubs for C++ clients
Headers and library of the gRPC messages and stubs, a CMake package with the
target Palpate::proto, and the .proto files for other languages.")
set(CPACK_COMPONENT_PYTHON_DESCRIPTION "Palpate: contact forces of soft bodies in Python
Models of soft bodies, a comparison of measured with estimated forces, constants
of materials, and a client of palpate-slave.")
include(CPack)
