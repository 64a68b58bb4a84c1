/* Gauss-Legendre quadrature with five points: ∫₀¹ f(u) du ≈ Σ_i weight_i f(node_i), exact to degree 9. */
#ifndef KM_BASE_NUMBER_GAUSS_LEGENDRE_H
#define KM_BASE_NUMBER_GAUSS_LEGENDRE_H

enum { KM_GAUSS_POINTS = 5 };
static const double km_gauss_node[KM_GAUSS_POINTS] = {0.5, 0.23076534494715845, 0.7692346550528415, 0.046910077030668,
                                                      0.953089922969332};
static const double km_gauss_weight[KM_GAUSS_POINTS] = {0.28444444444444444, 0.23931433524968324, 0.23931433524968324,
                                                        0.11846344252809454, 0.11846344252809454};

#endif
