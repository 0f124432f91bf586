mod identities;
mod oracles;
