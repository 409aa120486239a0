// SPDX-License-Identifier: MIT
#pragma once

// Everything but the headers that need an optional package, in the order of the data.
// clang-format off
#include <jampack/core/array.hpp>
#include <jampack/core/dimension.hpp>
#include <jampack/core/error.hpp>
#include <jampack/core/parallel.hpp>
#include <jampack/core/splitmix.hpp>

#include <jampack/geometry/ball.hpp>
#include <jampack/geometry/box.hpp>
#include <jampack/geometry/container.hpp>
#include <jampack/geometry/face_shape.hpp>
#include <jampack/geometry/frame.hpp>
#include <jampack/geometry/half_space.hpp>
#include <jampack/geometry/orientation.hpp>
#include <jampack/geometry/solid_angle.hpp>

#include <jampack/mesh/ball_mesh.hpp>
#include <jampack/mesh/boundary.hpp>
#include <jampack/mesh/boundary_surface.hpp>
#include <jampack/mesh/brick_mesh.hpp>
#include <jampack/mesh/disk_mesh.hpp>
#include <jampack/mesh/gmsh_reader.hpp>
#include <jampack/mesh/mesh.hpp>
#include <jampack/mesh/quality.hpp>
#include <jampack/mesh/refinement.hpp>
#include <jampack/mesh/sphere_points.hpp>

#include <jampack/element/averaged_dilatation.hpp>
#include <jampack/element/brick.hpp>
#include <jampack/element/composite_simplex.hpp>
#include <jampack/element/definite.hpp>
#include <jampack/element/element.hpp>
#include <jampack/element/linear_simplex.hpp>
#include <jampack/element/macro_simplex.hpp>
#include <jampack/element/quadratic_simplex.hpp>
#include <jampack/element/shape_gradients.hpp>
#include <jampack/element/tangent_sum.hpp>

#include <jampack/material/hencky.hpp>
#include <jampack/material/isotropic_moduli.hpp>
#include <jampack/material/linear_elastic.hpp>
#include <jampack/material/material.hpp>
#include <jampack/material/neo_hookean.hpp>
#include <jampack/material/st_venant_kirchhoff.hpp>
#include <jampack/material/volume_energy.hpp>

#include <jampack/body/block_cholesky.hpp>
#include <jampack/body/block_matrix.hpp>
#include <jampack/body/cholesky_structure.hpp>
#include <jampack/body/grain.hpp>
#include <jampack/body/grain_model.hpp>
#include <jampack/body/rigid_balls.hpp>
#include <jampack/body/rigid_walls.hpp>
#include <jampack/body/soft_packing.hpp>
#include <jampack/body/surface_measure.hpp>

#include <jampack/packing/handover.hpp>
#include <jampack/packing/random.hpp>
#include <jampack/packing/random_packing.hpp>

#include <jampack/detection/ball_gaps.hpp>
#include <jampack/detection/ball_warm_start.hpp>
#include <jampack/detection/broad_phase.hpp>
#include <jampack/detection/brute_force.hpp>
#include <jampack/detection/grain_surface.hpp>
#include <jampack/detection/r_tree.hpp>
#include <jampack/detection/surface_contact.hpp>
#include <jampack/detection/surface_detection.hpp>

#include <jampack/law/contact_law.hpp>
#include <jampack/law/friction_cone.hpp>
#include <jampack/law/hertz_check.hpp>
#include <jampack/law/signorini.hpp>
#include <jampack/law/signorini_coulomb.hpp>

#include <jampack/problem/block_sparse_delassus.hpp>
#include <jampack/problem/contact_problem.hpp>
#include <jampack/problem/delassus.hpp>
#include <jampack/problem/grain_compliance_delassus.hpp>
#include <jampack/problem/residual.hpp>
#include <jampack/problem/rigid_balls_delassus.hpp>
#include <jampack/problem/rows_times.hpp>
#include <jampack/problem/stored_blocks.hpp>

#include <jampack/solver/admm.hpp>
#include <jampack/solver/alart_curnier.hpp>
#include <jampack/solver/anderson.hpp>
#include <jampack/solver/block_sparse_lu.hpp>
#include <jampack/solver/colouring.hpp>
#include <jampack/solver/contact_groups.hpp>
#include <jampack/solver/contact_kernel.hpp>
#include <jampack/solver/contact_solver.hpp>
#include <jampack/solver/default_solver.hpp>
#include <jampack/solver/gauss_seidel.hpp>
#include <jampack/solver/gmres.hpp>
#include <jampack/solver/grain_newton_gmres.hpp>
#include <jampack/solver/grain_newton_matrix.hpp>
#include <jampack/solver/local_solver.hpp>
#include <jampack/solver/multifrontal_lu.hpp>
#include <jampack/solver/newton_matrix.hpp>
#include <jampack/solver/proximal_newton.hpp>
#include <jampack/solver/regularised_problem.hpp>
#include <jampack/solver/singular_block.hpp>
#include <jampack/solver/slip_direction.hpp>

#include <jampack/stepping/augmented_balance.hpp>
#include <jampack/stepping/ball_law.hpp>
#include <jampack/stepping/compaction.hpp>
#include <jampack/stepping/condensed_contacts.hpp>
#include <jampack/stepping/condensed_step.hpp>
#include <jampack/stepping/contact_spread.hpp>
#include <jampack/stepping/coupled_newton.hpp>
#include <jampack/stepping/hertz_balance.hpp>
#include <jampack/stepping/jam.hpp>
#include <jampack/stepping/moreau_rigid.hpp>
#include <jampack/stepping/press_to.hpp>
#include <jampack/stepping/soft_step.hpp>
#include <jampack/stepping/soft_step_options.hpp>
#include <jampack/stepping/watched_contacts.hpp>

#include <jampack/analysis/audit.hpp>
#include <jampack/analysis/audit_compliance.hpp>
#include <jampack/analysis/audit_network.hpp>
#include <jampack/analysis/audit_penetration.hpp>
#include <jampack/analysis/audit_report.hpp>
#include <jampack/analysis/audit_state.hpp>
#include <jampack/analysis/audit_surface.hpp>
#include <jampack/analysis/ball_network.hpp>
#include <jampack/analysis/compaction_fits.hpp>
#include <jampack/analysis/compaction_record.hpp>
#include <jampack/analysis/contact_approach.hpp>
#include <jampack/analysis/contact_counterparts.hpp>
#include <jampack/analysis/contact_network.hpp>
#include <jampack/analysis/contact_strain.hpp>
#include <jampack/analysis/coordination.hpp>
#include <jampack/analysis/coordination_law.hpp>
#include <jampack/analysis/elastic_moduli.hpp>
#include <jampack/analysis/field_statistics.hpp>
#include <jampack/analysis/grain_shape.hpp>
#include <jampack/analysis/granular_stress.hpp>
#include <jampack/analysis/heckel_secondi_law.hpp>
#include <jampack/analysis/hertz.hpp>
#include <jampack/analysis/hertz_cylinder.hpp>
#include <jampack/analysis/least_squares.hpp>
#include <jampack/analysis/merge_contact_points.hpp>
#include <jampack/analysis/micromechanical_law.hpp>
#include <jampack/analysis/power_law_fit.hpp>
#include <jampack/analysis/rattlers.hpp>
#include <jampack/analysis/record.hpp>
#include <jampack/analysis/small_strain_law.hpp>
#include <jampack/analysis/soft_network.hpp>
#include <jampack/analysis/sphere_compression_reference.hpp>
#include <jampack/analysis/sphericity_law.hpp>
#include <jampack/analysis/stress_field.hpp>
#include <jampack/analysis/von_mises.hpp>

#include <jampack/io/canvas.hpp>
#include <jampack/io/checkpoint.hpp>
#include <jampack/io/checkpoint_compaction.hpp>
#include <jampack/io/checkpoint_format.hpp>
#include <jampack/io/colour_map.hpp>
#include <jampack/io/coloured_surface.hpp>
#include <jampack/io/command_line.hpp>
#include <jampack/io/contact_problem_text.hpp>
#include <jampack/io/csv_table.hpp>
#include <jampack/io/csv_writer.hpp>
#include <jampack/io/curve_picture.hpp>
#include <jampack/io/failed_step.hpp>
#include <jampack/io/file.hpp>
#include <jampack/io/gnuplot.hpp>
#include <jampack/io/json.hpp>
#include <jampack/io/number.hpp>
#include <jampack/io/option_range.hpp>
#include <jampack/io/png.hpp>
#include <jampack/io/progress.hpp>
#include <jampack/io/pvd.hpp>
#include <jampack/io/run_program.hpp>
#include <jampack/io/soft_packing_picture.hpp>
#include <jampack/io/soft_packing_vtu.hpp>
#include <jampack/io/surface_picture.hpp>
#include <jampack/io/surface_renderer.hpp>
#include <jampack/io/vtu.hpp>
// clang-format on
