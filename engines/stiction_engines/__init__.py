"""Contact cases with known truths, run by several engines in the same way.

- `case`: a case, read from its JSON and URDF.
- `engine`: what an adapter of an engine implements.
- `adapters`: one file per engine.
- `urdf`: joints and shapes of a body's URDF.
- `series`, `measure`, `mechanics`: what a run leaves, and what is measured on it, the same for all engines.
- `sweep`, `cost`: cases x engines x steps, in processes of their own (`worker`, `worker_process`), and what
  they cost.
- `rows`, `tables`, `picture`: what a comparison leaves: tables for programs and readers, and a picture.
- `fclib`, `friction_problem`: contact problems of the runner in the format of FCLIB.
"""
