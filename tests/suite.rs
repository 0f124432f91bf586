
mod identities;
mod oracles;
