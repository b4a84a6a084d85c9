cmake_minimum_required(VERSION 3.16)
project(@{package} VERSION @{version} LANGUAGES C CXX)
find_package(ament_cmake REQUIRED)
find_package(hardware_interface REQUIRED)
find_package(pluginlib REQUIRED)
find_package(rclcpp REQUIRED)
find_package(transmission_interface REQUIRED)

add_library(@{package} SHARED ../@{p}.c @{p}_transmission_loader.cpp)
target_compile_features(@{package} PUBLIC c_std_99 cxx_std_17)
set_source_files_properties(../@{p}.c PROPERTIES COMPILE_OPTIONS "-fno-math-errno;-ffp-contract=off")
target_include_directories(@{package} PUBLIC
  $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}> $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/..>
  $<INSTALL_INTERFACE:include/@{package}>)
target_link_libraries(@{package} PUBLIC hardware_interface::hardware_interface pluginlib::pluginlib rclcpp::rclcpp
  transmission_interface::transmission_interface)
pluginlib_export_plugin_description_file(transmission_interface @{p}_transmission.xml)

install(TARGETS @{package} LIBRARY DESTINATION lib)
install(FILES ../@{p}.h @{p}_transmission.hpp DESTINATION include/@{package})
ament_package()
