# The targets vellus::vellus, the shared library, and vellus::static, for programs that contain the library.
get_filename_component(_vellus "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)
if(NOT TARGET vellus::vellus)
  add_library(vellus::vellus SHARED IMPORTED)
  set_target_properties(vellus::vellus PROPERTIES
    IMPORTED_LOCATION "${_vellus}/@SHARED@"
    IMPORTED_IMPLIB "${_vellus}/lib/vellus.lib"
    INTERFACE_INCLUDE_DIRECTORIES "${_vellus}/include")
  add_library(vellus::static STATIC IMPORTED)
  set_target_properties(vellus::static PROPERTIES
    IMPORTED_LOCATION "${_vellus}/@STATIC@"
    INTERFACE_LINK_LIBRARIES "@SYSTEM@"
    INTERFACE_INCLUDE_DIRECTORIES "${_vellus}/include")
endif()
unset(_vellus)
